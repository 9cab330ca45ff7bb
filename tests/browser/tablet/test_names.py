"""Who acts: a name that is chosen where the cell announces people, else written; STOP takes none."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.bench.fake_desk import leg
from tests.browser.tablet.bench.operator_hands import acted
from tests.browser.tablet.bench.screens import OUT_OF_REACH
from tests.browser.tablet.conftest import a_tablet

PEOPLE = ["Ada Lovelace", "Grace Hopper", "Wilhelmina Featherstonehaugh-Cholmondeley"]
REFUSED = "Grace Hopper is not among the people of this cell (Ada Lovelace). Let one of them confirm."
PHONE = {"width": 360, "height": 640}


@pytest.fixture
def nameless(chromium, url):
    with a_tablet(chromium, url, person=None, may_fail=True) as page:
        page.goto(f"{url}/operator/3")
        yield page


@pytest.fixture
def announced(desk, nameless):
    desk.show(people=PEOPLE)
    nameless.reload()
    nameless.locator("#dialogue .person").first.wait_for()
    return nameless


def test_one_of_those_announced_is_chosen_by_a_tap_and_nothing_is_written(desk, announced):
    expect(announced.locator("#dialogue input")).to_have_count(0)
    names = announced.locator("#dialogue .person")
    assert names.all_inner_texts() == PEOPLE
    assert min(names.evaluate_all("all => all.map(n => n.offsetHeight)")) >= 72

    names.nth(1).click()
    announced.get_by_role("button", name="Store now").click()

    assert acted(announced, desk)[0]["person"] == "Grace Hopper"
    announced.reload()
    expect(announced.locator("#person")).to_have_text("Grace Hopper")
    expect(announced.locator("#names")).to_have_text("B2T3")
    expect(announced.locator("#dialogue")).to_be_hidden()


def test_many_people_can_be_scrolled_to_on_a_phone_and_stop_stays_in_reach(desk, announced):
    desk.show(people=[f"Person {number}" for number in range(30)])
    announced.set_viewport_size(PHONE)
    announced.reload()

    announced.get_by_role("button", name="Person 29").scroll_into_view_if_needed()

    assert announced.evaluate(OUT_OF_REACH, ".control.stop") == []
    announced.get_by_role("button", name="Person 29").click()
    expect(announced.locator("#dialogue")).to_be_hidden()


def test_whoever_is_not_announced_watches_and_stops_and_is_asked_before_anything_else(desk, announced):
    announced.get_by_role("button", name="Watch only").click()
    expect(announced.locator("#dialogue")).to_be_hidden()

    announced.get_by_role("button", name="STOP").click()
    assert [(act["act"], act["person"]) for act in acted(announced, desk)] == [("stop", "No name")]
    announced.get_by_role("button", name="Store now").click()

    expect(announced.locator("#dialogue-title")).to_have_text("Who are you?")
    assert len(desk.acts) == 1


def test_a_name_that_was_kept_and_is_not_announced_is_asked_for_anew(desk, chromium, url):
    desk.show(people=PEOPLE)
    for person, asked in (("Mallory", True), ("grace  HOPPER", False)):
        with a_tablet(chromium, url, person=person) as page:
            page.goto(f"{url}/operator/3")
            expect(page.locator("#names")).to_have_text("B2T3")
            expect(page.locator("#dialogue")).to_be_visible(visible=asked)


def test_the_question_stays_while_others_go_on(desk, announced):
    desk.show(step=leg(3, 1))

    expect(announced.locator("#names")).to_have_text("B3T1")
    expect(announced.locator("#dialogue .person")).to_have_count(3)


def test_what_the_service_says_of_a_refused_name_stands_beside_the_names(desk, announced):
    announced.get_by_role("button", name="Grace Hopper").click()
    desk.name_refused = REFUSED
    desk.show(people=["Ada Lovelace"])

    announced.get_by_role("button", name="Store now").click()

    expect(announced.locator("#dialogue .refused")).to_have_text(REFUSED)
    expect(announced.locator("#dialogue .person")).to_have_text(["Ada Lovelace"])
    desk.name_refused = None
    announced.get_by_role("button", name="Ada Lovelace").click()
    announced.get_by_role("button", name="Store now").click()
    assert acted(announced, desk)[0]["person"] == "Ada Lovelace"


def test_what_the_service_says_of_a_refused_name_stands_beside_the_field(desk, nameless):
    nameless.get_by_label("Name", exact=True).fill("...")
    nameless.get_by_role("button", name="Save name").click()
    desk.name_refused = "person: a name must have a letter or a digit, and only visible characters."

    nameless.get_by_role("button", name="Store now").click()

    field = nameless.get_by_label("Name", exact=True)
    expect(field).to_have_accessible_description(desk.name_refused)
    expect(field).to_have_value("...")
