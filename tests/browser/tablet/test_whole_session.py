"""A whole session as an operator would do it, on the real service; with mishaps, the part that has them.

One session is walked from its plan to its end on the page. The others are taken up where the page has
something to prove: what comes before is done over REST, which spares the time that holds and texts take.
"""

import contextlib
import time

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.ages import drawn_ages
from tests.browser.tablet.bench.operator_hands import Operator
from tests.browser.tablet.bench.wire import wire_to
from tests.browser.tablet.bench.working_bench import (
    TABLET,
    WorkingBench,
    ledger,
    plan,
    serving,
    shown,
    walk_to_leg,
)
from tests.browser.tablet.conftest import a_tablet

READINGS = 4 + 4 + 7  # tool triangle and base triangle with their zeros; six legs with theirs


@pytest.fixture
def bench():
    return WorkingBench()


@pytest.fixture
def session(tmp_path, bench):
    with serving(tmp_path, bench) as url:
        yield url, plan(url)


def at_leg(number):
    return lambda screen, where: screen == "connect_leg" and f"length {number} of 6" in where


def measured(url, id):
    return [entry["step_id"] for entry in ledger(url, id) if entry["kind"] == "measured"]


def test_a_session_is_walked_through_on_the_page_alone(chromium, session):
    url, id = session
    # On a busy machine a confirmation may come so late that the service refuses it, and is given again.
    with a_tablet(chromium, url, may_fail=True) as page:
        page.goto(f"{url}/operator")
        page.locator("#sessions a").click()
        page.locator("body[data-screen=planned]").wait_for()
        operator = Operator(page)

        operator.walk(until="finished")

        expect(page.locator("#panel .facts")).to_contain_text(f"{READINGS} of {READINGS} readings")
    kept = measured(url, id)
    assert len(kept) == len(set(kept)) == READINGS
    moves = [screen for screen, _ in operator.seen if screen == "move"]
    confirmed = [e for e in ledger(url, id) if e["kind"] == "confirmed" and e["step_id"].endswith("/move")]
    assert len(moves) == len(confirmed) == 4  # three cups and a pose, each confirmed by a person
    assert {entry["person"] for entry in confirmed} == {"Ada Byron"}


def test_a_session_survives_lost_wifi_a_closed_lid_and_a_restart(chromium, tmp_path, bench):
    with contextlib.ExitStack() as first:
        url = first.enter_context(serving(tmp_path, bench))
        id = plan(url)
        walk_to_leg(3, url, id)
        with wire_to(url) as (wire, near), a_tablet(chromium, near, may_fail=True, tablet=TABLET) as page:
            page.goto(f"{near}/operator/{id}")
            page.locator("body[data-screen=connect_leg]").wait_for()
            operator = Operator(page)

            wire.cut()
            expect(page.locator("#lost")).to_be_visible()
            page.get_by_role("button", name="Pause").click()
            expect(page.locator("#queued")).to_have_attribute("data-count", "1")
            wire.heal()
            page.locator("body[data-screen=paused]").wait_for()
            operator.walk(until=at_leg(4))

            page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
            operator.walk(until=at_leg(5))

            before, kept = shown(url, id)["step"]["id"], measured(url, id)
            wire.cut()
            first.close()
            moves = bench.robot.moves
            with serving(tmp_path, bench) as second:  # the cell itself stands as it stood
                wire.leads_to(second)
                wire.heal()
                page.locator("body[data-screen=interrupted]").wait_for()
                assert bench.robot.moves == moves
                assert shown(second, id)["step"]["id"] == before
                assert measured(second, id) == kept

                operator.walk(until="finished")

                kept = measured(second, id)
                assert len(kept) == len(set(kept)) == READINGS


def test_a_wrong_pair_is_not_stored_and_the_right_one_is(chromium, session):
    url, id = session
    walk_to_leg(4, url, id)
    with a_tablet(chromium, url, tablet=TABLET) as page:
        page.goto(f"{url}/operator/{id}")
        page.locator("body[data-screen=connect_leg]").wait_for()
        operator = Operator(page)

        page.locator("[data-hand=other]").click()
        page.get_by_role("button", name="B2\u2013T2").click()  # read a moment ago
        page.locator("body[data-screen=doubt]").wait_for()
        assert len(measured(url, id)) == 4 + 4 + 4
        page.get_by_role("button", name="I have reconnected the ballbar").click()
        page.locator("body[data-screen=connect_leg]").wait_for()
        operator.walk(until="finished")

    kept = measured(url, id)
    assert len(kept) == len(set(kept)) == READINGS


def test_two_tablets_of_one_session(chromium, session):
    url, id = session
    with a_tablet(chromium, url) as ada, a_tablet(chromium, url, person="Grace Hopper") as grace:
        for page in (ada, grace):
            page.goto(f"{url}/operator/{id}")
        ada.locator("body[data-screen=planned]").wait_for()
        Operator(ada).walk(until="measure_side")
        expect(grace.locator("#who")).to_have_text(
            "Ada Byron has control on another tablet \u00b7 1 watching"
        )

        grace.get_by_role("button", name="Take over").click()
        grace.locator("#dialogue").get_by_role("button", name="Take over").click()
        expect(ada.locator("#who")).to_contain_text("Grace Hopper has control")
        Operator(grace).walk(until="detach")

        assert shown(url, id)["acting"]["person"] == "Grace Hopper"


def test_the_length_on_the_page_is_young(chromium, session):
    url, id = session
    with a_tablet(chromium, url) as page:
        page.goto(f"{url}/operator/{id}")
        page.locator("body[data-screen=planned]").wait_for()
        Operator(page).walk(until="measure_side")
        time.sleep(0.5)

        ages, allowed_ms = drawn_ages(page, 4000)

    assert len(ages) >= 20  # of the 20 Hz of the cell's clock; a busy machine draws fewer
    assert ages[int(0.95 * len(ages))] <= allowed_ms
