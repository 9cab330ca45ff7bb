"""The list of sessions, the start of a new one, and the steps listed before anything moves."""

import threading

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg, move, step
from tests.browser.tablet.bench.operator_hands import acted
from tests.browser.tablet.conftest import a_tablet
from tests.browser.windows import LANDSCAPE, PORTRAIT


def session(id, state, role="ballbar"):
    return {"id": id, "name": f"bay {id}", "role": role, "state": state, "measured": 40 * id, "planned": 431}


@pytest.fixture
def page(chromium, url):
    with a_tablet(chromium, url) as page:
        yield page


def test_sessions_of_every_kind_are_listed_newest_first(desk, page, url):
    desk.sessions = [session(1, "finished"), session(2, "running", "calibration"), session(3, "paused")]

    page.goto(f"{url}/operator")

    rows = page.locator("#sessions li")
    expect(rows).to_have_count(3)
    expect(rows.nth(0)).to_contain_text("bay 3paused120 of 431 poses measured")
    expect(rows.nth(1)).to_contain_text("bay 2running")
    expect(rows.nth(2)).to_contain_text("finished")
    for size in (LANDSCAPE, PORTRAIT):
        page.set_viewport_size(size)
        assert page.evaluate("document.documentElement.scrollWidth") == size["width"]
    rows.nth(0).click()
    page.wait_for_url("**/operator/3")
    expect(page.locator("#names")).to_have_text("B2T3")


def test_more_sessions_than_one_answer_holds_are_listed_too(desk, page, url):
    desk.sessions = [session(id, "finished") for id in range(1, 131)]

    page.goto(f"{url}/operator")

    expect(page.locator("#sessions li")).to_have_count(130)


def test_a_new_session_is_planned_with_what_was_chosen(desk, page, url):
    page.goto(f"{url}/operator")
    expect(page.locator("#none")).to_be_visible()
    estimate = page.locator("#estimate").inner_text()
    page.get_by_label("Name").fill("left arm")
    page.get_by_role("group", name="Placements").get_by_text("2").click()
    page.get_by_role("group", name="Cups").get_by_text("4").click()
    page.get_by_role("group", name="Poses").get_by_text("12").click()
    assert page.locator("#estimate").inner_text() != estimate

    page.get_by_role("button", name="Plan the session").click()

    page.wait_for_url("**/operator/3")
    assert desk.planned == [
        {"kind": "ballbar", "name": "left arm", "placement_count": 2, "base_points": 4, "poses": 12}
    ]


def test_planning_is_waited_for_and_seen_to_go_on(desk, page, url):
    desk.planning = threading.Event()
    page.goto(f"{url}/operator")
    page.get_by_label("Name").fill("left arm")

    page.get_by_role("button", name="Plan the session").click()

    expect(page.locator("#plan")).to_have_text("Planning … 0:02")
    expect(page.locator("#plan")).to_be_disabled()
    expect(page.locator("#estimate")).to_contain_text("some minutes")
    page.get_by_label("Language").select_option("fr")
    expect(page.locator("#plan")).to_contain_text("Planification … 0:0")
    desk.planning.set()
    page.wait_for_url("**/operator/3")
    assert len(desk.planned) == 1


def test_a_plan_whose_answer_was_lost_is_found_in_the_list(desk, chromium, url):
    desk.sessions = [session(1, "finished") | {"name": "left arm"}]
    desk.planning = threading.Event()  # is never set: the answer does not come
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator")
        expect(page.locator("#sessions li")).to_have_count(1)
        page.get_by_label("Name").fill("left arm")
        page.get_by_role("button", name="Plan the session").click()
        expect(page.locator("#plan")).to_be_disabled()

        desk.sessions = [*desk.sessions, session(3, "planned") | {"name": "left arm"}]

        page.wait_for_url("**/operator/3")
        desk.planning.set()


def test_a_request_to_plan_that_broke_is_repeated_with_its_key(desk, chromium, url):
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator")
        page.get_by_label("Name").fill("left arm")
        broken = []
        page.route("**/api/v1/sessions", lambda route: (broken.append(route.request.headers), route.abort()))
        page.get_by_role("button", name="Plan the session").click()
        while not broken:
            page.wait_for_timeout(20)
        page.unroute("**/api/v1/sessions")

        page.wait_for_url("**/operator/3")

    assert len(desk.plan_keys) == 1
    assert {headers["idempotency-key"] for headers in broken} == set(desk.plan_keys)


def test_what_is_tapped_is_large_and_a_session_without_a_name_is_not_planned(desk, page, url):
    page.goto(f"{url}/operator")
    page.locator("#estimate:not(:empty)").wait_for()

    tapped = page.locator(".choices .choice span, form .main")
    for size in (LANDSCAPE, PORTRAIT):
        page.set_viewport_size(size)
        assert min(tapped.evaluate_all("all => all.map(b => b.offsetHeight)")) >= 72

    page.get_by_role("button", name="Plan the session").click()
    page.wait_for_timeout(200)

    assert desk.planned == []


def test_the_steps_and_the_length_are_known_beforehand(desk, page, url):
    poses = [
        one
        for pose in (1, 2)
        for one in (
            move(pose),
            step("initialise", id=f"i{pose}", config=pose),
            *(leg(a, b, pose=pose) for a, b in ((1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 1))),
            step("detach", id=f"d{pose}", config=pose),
        )
    ]
    sides = [step("measure_side", id="tool/side-1-2", artefact="tool", points=["T1", "T2"], placement=None)]
    desk.steps = [*sides, *poses]
    desk.show(state="planned", step=sides[0])
    page.goto(f"{url}/operator/3")

    expect(page.locator("#panel .facts")).to_have_text("431 readings in 19 steps, about 1 h 30 min.")
    expect(page.locator("#panel summary").nth(1)).to_contain_text("Placement 1, pose 1")
    expect(page.locator("#panel summary").nth(1)).to_contain_text("9 steps, 7 readings")
    page.locator("#panel summary").nth(1).click()
    expect(page.locator("#panel details[open] li")).to_have_count(9)
    expect(page.locator("#panel details[open] li").nth(2)).to_have_text("Connect the ballbar: B1\u2013T1")
    page.get_by_role("button", name="Start the session").click()
    assert [act["act"] for act in acted(page, desk)] == ["start"]


def test_what_was_left_out_is_told_at_the_end_with_its_reason(desk, page, url):
    out = {"outcome": "skipped", "text": "Out of range: too long"}
    done = {"outcome": "measured", "length_mm": 300.1}
    desk.steps = [
        {**leg(1, 1), **done},
        *({**leg(2, tool), **out} for tool in (1, 2)),
        {**leg(1, 1, pose=13), **out},
        {**leg(1, 1, pose=13, attempt=2), **done},  # tried again, and measured
    ]
    desk.show(state="finished", step=None)
    page.goto(f"{url}/operator/3")

    expect(page.locator(".left-out li")).to_have_count(1)
    expect(page.locator(".left-out li")).to_contain_text("pose 12: B2\u2013T1, B2\u2013T2")
    expect(page.locator(".left-out li")).to_contain_text("Out of range: too long")


def test_what_was_measured_leads_on_and_nothing_does_not(desk, page, url):
    desk.show(state="finished", step=None, result_url="/sessions/3/result")
    page.goto(f"{url}/operator/3")
    expect(page.get_by_role("link", name="Show the result")).to_have_attribute("href", "/sessions/3/result")

    desk.show(state="aborted", step=None, progress={**desk.session["progress"], "readings": 0})
    page.reload()

    expect(page.get_by_role("link", name="All sessions")).to_be_visible()
    expect(page.get_by_role("link", name="Show the result")).to_have_count(0)


def test_what_was_skipped_and_measured_meanwhile_is_not_left_out_at_the_end(desk, page, url):
    skipped = {"outcome": "skipped", "text": "Out of range: too long"}
    first, second = leg(1, 1), {**leg(1, 1, attempt=2), "id": "placement-1/pose-12/again/leg-1-1"}
    desk.steps = [{**first, **skipped}, second]
    desk.show(step=second)
    page.goto(f"{url}/operator/3")
    expect(page.locator("#names")).to_have_text("B1T1")
    page.wait_for_timeout(300)  # the steps are known by now, and not yet the end

    desk.steps = [{**first, **skipped}, {**second, "outcome": "measured", "length_mm": 300.1}]
    desk.show(state="finished", step=None)

    expect(page.locator("#panel h2")).to_have_text("Nothing was skipped.")


def test_a_session_that_is_not_there_is_told(desk, chromium, url):
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator/77")

        expect(page.locator("#names")).to_have_text("NO SUCH SESSION")
        expect(page.locator("#actions button")).to_have_count(0)
