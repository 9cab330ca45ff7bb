"""A session that runs by itself, on the real page of the real service: its steps, its verbs, mishaps."""

import contextlib

import httpx
import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.guided_bench import GuidedBench, guide, plan, serving, until
from tests.browser.tablet.bench.operator_hands import hold_long_enough
from tests.browser.tablet.bench.wire import wire_to
from tests.browser.tablet.bench.working_bench import PATIENCE_S
from tests.browser.tablet.conftest import a_tablet
from tests.browser.windows import LANDSCAPE

VERBS = ["Back", "Retry", "Skip", "Pause", "Abort", "STOP"]
NO_NUMBER = " ".join(3 * ["\u2013"])
PHONE = {"width": 390, "height": 844}
# What would set the arm going if it were tapped, by the act that it sends.
LETS_MOVE = "[data-act=confirm], [data-act=resume]:not(.control), [data-act=start]"

LOOK = """() => {
  const seen = (node) => node.getClientRects().length > 0;
  const box = (node) => [node.innerText.trim(), Math.round(node.getBoundingClientRect().height)];
  const buttons = [...document.querySelectorAll('button, a.main, a.home')].filter(seen);
  const drawn = (svg) => seen(svg.parentNode) && svg.children.length > 0;
  const covered = (node) => {
    const { left, right, top, bottom } = node.getBoundingClientRect();
    const y = (top + bottom) / 2;
    const seen = [left + 2, (left + right) / 2, right - 2].map((x) => document.elementFromPoint(x, y));
    return seen.some((found) => !found?.closest('#caution'));
  };
  const inside = (node) => node.closest('#actions, #dock');
  return {
    screen: document.body.dataset.screen,
    main: buttons.filter((node) => inside(node)).map(box),
    other: buttons.filter((node) => !inside(node)).map(box),
    pictures: [...document.querySelectorAll('.board svg')].filter((svg) => svg.getClientRects().length &&
    svg.children.length).length, wide: document.documentElement.scrollWidth - innerWidth,
    covered: [...document.querySelectorAll('#caution:not([hidden]) *')].filter(covered).length,
  };
}"""


@pytest.fixture(scope="module")
def bench():
    return GuidedBench()


@pytest.fixture(scope="module")
def url(tmp_path_factory, bench):
    with serving(tmp_path_factory.mktemp("guided"), bench) as url:
        yield url


@pytest.fixture
def ended(url):
    """Whatever a test left under way is ended: one session runs at a time."""
    yield
    for session in httpx.get(f"{url}/api/v1/sessions", timeout=PATIENCE_S).json():
        if session["state"] not in {"finished", "aborted", "failed", "planned"}:
            end = {"command": "abort"}
            httpx.post(f"{url}/api/v1/sessions/{session['id']}/commands", json=end, timeout=PATIENCE_S)
            until(url, session["id"], lambda found: found["state"] in {"aborted", "finished"})


def on(page, *screens):
    names = ", ".join(f"body[data-screen={screen}]" for screen in screens)
    page.locator(names).wait_for(timeout=1000 * PATIENCE_S)


def held(page, name="Hold: the cell is clear"):
    button = page.get_by_role("button", name=name)
    expect(button).to_be_enabled()
    button.hover()
    hold_long_enough(page)


def started(page, url, id):
    page.goto(f"{url}/operator/{id}")
    page.get_by_role("button", name="Next: place the tracker").click()
    page.get_by_role("button", name="Start the session").click()
    on(page, "ask")
    held(page)


def fit(look, *, least=72):
    """Whether every control that a screen shows is large enough for a glove."""
    small = [(name, height) for name, height in look["main"] if height < least]
    return small + [(name, height) for name, height in look["other"] if height < 48]


def test_a_session_is_walked_through_on_the_page_alone(chromium, url, bench, ended):
    id = plan(url, 8, warm_up=True, reference_every=2)
    seen = {}
    with a_tablet(chromium, url, size=LANDSCAPE) as page:
        page.goto(f"{url}/operator")
        page.locator(f"#sessions a[href='/operator/{id}']").click()
        on(page, "who")
        page.locator(".board svg > *").first.wait_for(timeout=1000 * PATIENCE_S)
        seen["who"] = page.evaluate(LOOK)
        page.get_by_role("button", name="Next: place the tracker").click()
        expect(page.get_by_text("8 of 8 configurations are in sight.")).to_be_visible()
        seen["place"] = page.evaluate(LOOK)
        page.get_by_role("button", name="Start the session").click()
        on(page, "ask")
        expect(page.locator("#caution")).to_contain_text("Only the emergency stop")
        assert bench.robot.moves == 0
        seen["ask"] = page.evaluate(LOOK)
        bench.clock.pace = 25
        held(page)
        on(page, "warm")
        expect(page.locator("#curve circle")).not_to_have_count(0)
        seen["warm"] = page.evaluate(LOOK)
        expect(page.locator(LETS_MOVE)).to_have_count(0)
        on(page, "measure")
        bench.clock.pace = 3
        expect(page.locator("#rows tr.active")).to_have_count(1)
        seen["measure"] = page.evaluate(LOOK)
        expect(page.locator(LETS_MOVE)).to_have_count(0)  # nothing here sets the arm going
        page.locator("#watch[data-state=within]").wait_for(timeout=1000 * PATIENCE_S)
        until(url, id, lambda found: found["progress"]["done"] >= 1)
        page.get_by_role("button", name="Pause").click()
        on(page, "paused")
        seen["paused"] = page.evaluate(LOOK)
        page.get_by_role("button", name="Configuration 1, measured").click()
        expect(page.locator("#panel")).to_contain_text("Configuration 1 selected")
        page.get_by_role("button", name="Retry").click()
        expect(page.get_by_role("button", name="Configuration 1, pending")).to_be_visible()
        bench.clock.pace = 40
        held(page)
        on(page, "ask")  # what is wanted again comes last, and after a question
        expect(page.locator("#panel")).to_contain_text("configuration 1")
        held(page)
        on(page, "finished")
        expect(page.get_by_role("link", name="Show the result")).to_be_visible()
        page.wait_for_timeout(700)
        seen["finished"] = page.evaluate(LOOK)

    assert guide(url, id)["progress"]["done"] == 8
    for screen, look in seen.items():
        assert fit(look) == [], screen
        verbs = [name.replace("Resume", "Pause") for name, _ in look["main"]][-6:]
        assert verbs == VERBS, screen
        assert look["wide"] <= 0, screen
        assert look["covered"] == 0, screen  # that only the emergency stop stops the arm at once
    assert {
        screen: look["pictures"] for screen, look in seen.items() if screen != "finished"
    } == dict.fromkeys(["who", "place", "ask", "warm", "measure", "paused"], 1)


def test_taps_without_a_network_arrive_once_each(chromium, url, bench, ended):
    id = plan(url, 30, reference_every=30)
    bench.clock.pace = 4
    with wire_to(url) as (wire, near), a_tablet(chromium, near, size=LANDSCAPE, may_fail=True) as page:
        started(page, near, id)
        on(page, "measure")
        wire.cut()
        expect(page.locator("#lost")).to_be_visible()
        for config in (20, 21):
            page.get_by_role("button", name=f"Configuration {config}, pending").click()
            page.get_by_role("button", name="Skip").click()
            page.get_by_text("Something blocks the beam").click()
            page.get_by_role("button", name="Skip this configuration").click()
        page.get_by_role("button", name="Pause").click()
        expect(page.locator("#queued")).to_have_attribute("data-count", "3")
        wire.heal()
        on(page, "paused")

    sheet = httpx.get(f"{url}/api/v1/sessions/{id}/sheet", timeout=PATIENCE_S).json()
    left_out = [row["config"] for row in sheet["points"] if row["status"] == "left_out"]
    assert left_out == [20, 21]
    skipped = httpx.get(f"{url}/api/v1/sessions/{id}", timeout=PATIENCE_S).json()["skipped_stops"]
    assert [stop["config"] for stop in skipped] == [20, 21]


def test_a_session_is_taken_up_at_the_same_step_after_a_restart(chromium, tmp_path):
    bench = GuidedBench(pace=10)
    with contextlib.ExitStack() as first:
        url = first.enter_context(serving(tmp_path, bench))
        id = plan(url, 6, reference_every=6)
        with wire_to(url) as (wire, near), a_tablet(chromium, near, size=LANDSCAPE, may_fail=True) as page:
            started(page, near, id)
            until(url, id, lambda found: found["progress"]["done"] >= 2)
            wire.cut()
            bench.clock.pace = 1  # no configuration ends while the service does, on a busy machine neither
            before = guide(url, id)
            first.close()
            moves = bench.robot.moves
            with serving(tmp_path, bench) as second:
                wire.leads_to(second)
                wire.heal()
                on(page, "ask")
                after = guide(second, id)
                assert after["progress"]["done"] in {
                    before["progress"]["done"],
                    before["progress"]["done"] + 1,
                }
                assert bench.robot.moves <= moves + 1  # a motion that was under way ends by itself
                assert after["prompt"] is None  # nobody runs it: the answer has it asked anew
                bench.clock.pace = 60
                held(page)
                on(page, "finished")
                assert guide(second, id)["progress"]["done"] == 6


def test_a_lost_beam_is_said_and_the_phone_shows_it_all(chromium, url, bench, ended):
    id = plan(url, 6)
    bench.clock.pace = 10
    with a_tablet(chromium, url, size=PHONE) as page:
        started(page, url, id)
        on(page, "measure")
        bench.tracker.beam_cut = True
        try:
            expect(page.locator("#watch[data-state=no_signal]")).to_be_visible()
            expect(page.locator("#distance")).to_have_text(NO_NUMBER)
            expect(page.locator("#advice")).not_to_have_text("")
            look = page.evaluate(LOOK)
        finally:
            bench.tracker.beam_cut = False
        page.get_by_role("button", name="Unit of length").click()
        expect(page.locator("#units")).to_have_text("in")
        page.locator("#language").select_option("fr")
        expect(page.locator("#names")).to_contain_text("Configuration")
        expect(page.locator("#kicker")).to_have_text("Elle mesure seule\u00a0; restez dehors")
    assert fit(look, least=56) == []  # a phone only looks on: its verbs are smaller, STOP is not
    assert dict(look["main"])["STOP"] >= 66
    assert look["wide"] <= 0
