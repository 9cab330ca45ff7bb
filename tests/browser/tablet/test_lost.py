"""Wi-Fi gone, lid closed, answers lost: nothing is lost, nothing done twice, nothing old moves the robot."""

import time

from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, move, step
from tests.browser.tablet.bench.operator_hands import hold_long_enough
from tests.browser.tablet.conftest import a_tablet

BANNER_TICKS = 20  # of 100 ms of the page's own time, which a busy machine makes no more
# Counts from the last length that came to the word that the link is lost.
TICKS_OF_SILENCE = """() => {
    const [gauge, lost] = [document.querySelector("#gauge"), document.querySelector("#lost")];
    let [ticks, sampled] = [0, 0];
    setInterval(() => { ticks += 1; }, 100);
    const heard = () => {
        if (!(Number(gauge.dataset.sampledAtMs) > sampled)) return;
        [ticks, sampled] = [0, Number(gauge.dataset.sampledAtMs)];
    };
    new MutationObserver(heard).observe(gauge, { attributes: true });
    const told = () => lost.hidden || (window.told ??= ticks);
    new MutationObserver(told).observe(lost, { attributes: true });
}"""
PATIENCE_MS = 60_000

# Other languages follow behind the page, which takes its time on a busy machine.
FRENCH_FOLLOWED = """() => {
  const files = new Set(performance.getEntriesByType('resource').map((entry) => entry.name));
  const loaded = (language) => [...files].filter((name) => name.endsWith(`/${language}.json`)).length;
  return loaded('en') > 0 && loaded('fr') === loaded('en');
}"""


def lost(page, wire):
    wire.cut()
    expect(page.locator("#lost")).to_be_visible(timeout=PATIENCE_MS)


def back(page, wire):
    wire.heal()
    page.locator("#link[data-state=up]").wait_for()


def settled(page, desk, n):
    """Wait until the desk has carried out `n` acts, and a little longer for one too many."""
    for _ in range(500):
        if len(desk.acts) >= n:
            break
        page.wait_for_timeout(20)
    page.wait_for_timeout(300)
    return [act["act"] for act in desk.acts]


def test_a_silent_link_is_told_within_two_seconds_in_any_language_and_comes_back_by_itself(desk, wired):
    page, wire = wired
    page.wait_for_function(FRENCH_FOLLOWED)
    page.evaluate(TICKS_OF_SILENCE)

    lost(page, wire)

    assert 0 < page.evaluate("window.told") <= BANNER_TICKS
    expect(page.locator("#lost")).to_contain_text("emergency stop")
    expect(page.locator("#gauge")).to_have_attribute("data-state", "no_signal")  # an old length is no length
    expect(page.locator("#word")).to_have_text("No connection")  # nobody is sent to the cable of the bar
    expect(page.locator("#advice")).to_contain_text("can leave the ballbar where it is")
    for language, said in (("fr", "Pas de connexion au service."), ("en", "No connection to the service.")):
        page.locator("#language").select_option(language)
        expect(page.locator("#lost")).to_contain_text(said)

    desk.show(step=leg(3, 1), progress={**desk.session["progress"], "readings": 90})
    back(page, wire)

    expect(page.locator("#lost")).to_be_hidden()
    expect(page.locator("#names")).to_have_text("B3T1")
    expect(page.locator("#progress")).to_contain_text("90 of 431 readings")


def test_a_quiet_session_is_not_taken_for_a_lost_one(desk, wired):
    page, _ = wired
    desk.sample = None  # a heartbeat each second, and nothing else

    page.wait_for_timeout(3500)

    expect(page.locator("#lost")).to_be_hidden()


def test_taps_wait_with_their_number_and_are_sent_once_in_order(desk, wired):
    page, wire = wired
    desk.show(step=step("detach", id="placement-1/pose-12/detach"))
    page.locator("body[data-screen=detach]").wait_for()
    lost(page, wire)

    page.get_by_role("button", name="Done").click()
    page.get_by_role("button", name="Pause").click()
    expect(page.locator("#queued")).to_have_attribute("data-count", "2")
    expect(page.locator("#queued")).to_contain_text("2 taps are waiting")
    expect(page.locator("#actions button")).to_be_disabled()  # the same tap again would be another one
    page.get_by_role("button", name="STOP").click()
    expect(page.locator("#said")).to_contain_text("has not reached the robot")
    expect(page.locator("#said")).to_contain_text("emergency stop")
    assert desk.arrived == []
    healed_s = time.monotonic()
    back(page, wire)

    assert settled(page, desk, 3) == ["confirm", "pause", "stop"]
    assert all(healed_s - 60 < act["pressed_at_s"] < healed_s for act in desk.arrived)  # not when they came
    assert len({act["key"] for act in desk.arrived}) == 3
    expect(page.locator("#queued")).to_be_hidden()


def test_a_tap_whose_answer_was_lost_is_done_once(desk, wired):
    page, wire = wired
    wire.lose_answers()

    page.get_by_role("button", name="Store now").click()
    expect(page.locator("#lost")).to_be_visible(timeout=PATIENCE_MS)
    assert settled(page, desk, 1) == ["store"]
    back(page, wire)

    for _ in range(200):
        if len(desk.arrived) >= 2:
            break
        page.wait_for_timeout(50)
    assert len(desk.arrived) >= 2  # it was sent again
    assert len({act["key"] for act in desk.arrived}) == 1  # with the key it had
    assert settled(page, desk, 1) == ["store"]
    assert page.evaluate("JSON.parse(localStorage.getItem('truepose.taps.3'))") == []


def test_an_answer_lost_behind_a_gateway_is_no_refusal(desk, chromium, url):
    desk.lost_answers = 2
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator/3")
        page.get_by_role("button", name="Store now").click()

        for _ in range(200):
            if len(desk.arrived) >= 3:
                break
            page.wait_for_timeout(50)
        assert settled(page, desk, 1) == ["store"]
        assert len({act["key"] for act in desk.arrived}) == 1


def test_taps_outlive_the_page(desk, chromium, url):
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator/3")
        page.get_by_role("button", name="Store now").wait_for()
        page.locator("#link[data-state=up]").wait_for()
        page.context.route("**/commands", lambda route: route.abort())
        page.get_by_role("button", name="Pause").click()
        page.wait_for_timeout(200)
        assert desk.arrived == []

        page.context.unroute("**/commands")
        page.reload()

        assert settled(page, desk, 1) == ["pause"]


def test_a_tap_whose_step_is_gone_is_dropped_with_a_sentence(desk, wired):
    page, wire = wired
    lost(page, wire)
    page.get_by_role("button", name="Store now").click()
    page.get_by_role("button", name="Pause").click()

    desk.show(step=leg(3, 1))
    back(page, wire)

    expect(page.locator("#said")).to_contain_text("“Store now” was not carried out: the session is no longer")
    expect(page.locator("#said")).to_contain_text("B2\u2013T3)")
    assert settled(page, desk, 1) == ["pause"]  # it belongs to no step
    expect(page.locator("#names")).to_have_text("B3T1")


def test_a_motion_is_not_confirmed_while_the_connection_is_lost(desk, wired):
    page, wire = wired
    desk.show(step=move(), ballbar_attached=False)
    page.locator("body[data-screen=move]").wait_for()
    lost(page, wire)

    expect(page.locator("#actions button")).to_be_disabled()
    expect(page.locator("#panel")).to_contain_text("a late confirmation must not move the robot")
    back(page, wire)
    page.wait_for_timeout(500)

    assert desk.arrived == []
    expect(page.locator("#actions button")).to_be_enabled()


def test_a_confirmation_of_a_motion_that_went_unheard_is_never_sent_again(desk, chromium, url):
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator/3")
        desk.show(step=move(), ballbar_attached=False)
        page.locator("body[data-screen=move]").wait_for()
        page.context.route("**/commands", lambda route: route.abort())

        page.get_by_role("button", name="Hold").hover()
        hold_long_enough(page)
        expect(page.locator("#said")).to_contain_text("not sent again")
        page.context.unroute("**/commands")
        page.reload()
        page.locator("#link[data-state=up]").wait_for()
        page.wait_for_timeout(1500)

        assert desk.arrived == []


def test_a_hold_that_outlasts_the_connection_moves_nothing(desk, wired):
    page, wire = wired
    desk.show(step=move(), ballbar_attached=False)
    page.get_by_role("button", name="Hold").hover()
    wire.cut()
    page.wait_for_timeout(700)

    page.mouse.down()
    expect(page.locator("#lost")).to_be_visible(timeout=PATIENCE_MS)
    page.wait_for_timeout(1000)
    page.mouse.up()
    back(page, wire)
    page.wait_for_timeout(500)

    assert desk.arrived == []


def test_what_could_not_be_read_is_read_again(desk, chromium, url):
    missing = {"v1/simulated-hands", "3/scene", "3/plan", "common/fr.json"}
    with a_tablet(chromium, url, may_fail=True) as page:
        for path in missing:
            page.route(f"**/{path}", lambda route: route.abort(), times=2)
        page.on("response", lambda reply: missing.discard("/".join(reply.url.split("/")[-2:])))
        page.goto(f"{url}/operator/3")

        page.locator("[data-hand=asked]").wait_for(timeout=PATIENCE_MS)
        assert page.locator("[data-hand=asked]").count() == 1
        page.locator("#picture .point.asked").first.wait_for(timeout=PATIENCE_MS)
        for _ in range(200):
            if not missing:
                break
            page.wait_for_timeout(50)
    assert not missing


def test_an_answer_that_was_cut_off_is_none(desk, chromium, url):
    with a_tablet(chromium, url) as page:
        cut_off = {"status": 200, "content_type": "application/json", "body": '{"simul'}
        page.route("**/simulated-hands", lambda route: route.fulfill(**cut_off), times=1)
        page.goto(f"{url}/operator/3")

        page.locator("[data-hand=asked]").wait_for(timeout=PATIENCE_MS)
        assert page.locator("[data-hand=asked]").count() == 1


def test_no_is_an_answer(desk, chromium, url):
    desk.simulated = False
    asked = []
    with a_tablet(chromium, url) as page:
        page.on("request", lambda request: asked.append(request.url))
        page.goto(f"{url}/operator/3")
        page.locator("#link[data-state=up]").wait_for()
        page.wait_for_timeout(1500)  # longer than what was not answered waits

        expect(page.locator("[data-hand=asked]")).to_have_count(0)
    assert len([address for address in asked if address.endswith("simulated-hands")]) == 1


def test_a_tablet_that_slept_starts_afresh(desk, tablet):
    tablet.locator("#link[data-state=up]").wait_for()
    with (
        tablet.expect_request("**/live?*"),
        tablet.expect_response(lambda r: r.url.endswith("/sessions/3/situation")),
    ):
        # What a browser says when the lid is opened; a test has no lid.
        tablet.evaluate("document.dispatchEvent(new Event('visibilitychange'))")

    tablet.locator("#link[data-state=up]").wait_for()
    expect(tablet.locator("#word")).to_have_text("In range")


AWAKE = """
    window.locks = 0;
    const request = async () => { window.locks += 1; };
    Object.defineProperty(navigator, "wakeLock", { value: { request } });
"""


def test_the_screen_is_kept_awake_where_the_browser_can(desk, chromium, url):
    with a_tablet(chromium, url, scripts=[AWAKE]) as page:
        page.goto(f"{url}/operator/3")
        page.locator("#link[data-state=up]").wait_for()

        assert page.evaluate("window.locks") == 1


def test_a_disk_that_refuses_is_said_until_it_does_not(desk, tablet):
    refused = "The database cannot be written (the disk is full). Nothing moves."
    notice = tablet.locator("#trouble")
    expect(notice).to_be_hidden()

    desk.show(trouble=refused)
    expect(notice).to_have_text(refused)

    desk.show(trouble=None)
    expect(notice).to_be_hidden()
