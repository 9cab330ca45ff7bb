"""Own readings in a browser, by somebody who has never seen the program: from a table to the named cause."""

import time
from types import SimpleNamespace

import pytest
from playwright.sync_api import expect

from tests.browser.conftest import settings_in
from tests.helpers.web.performing import perform_here
from tests.integration.web.bench import Bench
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.exchange.import_wizard.files import example_files

MOST_TAPS = 10
MOST_S = 180.0


@pytest.fixture(scope="module")
def service(tmp_path_factory, empty_database):
    where = settings_in(tmp_path_factory.mktemp("shop"), empty_database)
    with listening(create_app(where, Bench().registry(), perform_here)) as url:
        yield SimpleNamespace(url=url)


@pytest.fixture
def own_table(tmp_path):
    """A table as a spreadsheet of a German shop writes it, with one torn cell."""
    lines = example_files()["left arm.csv"].decode().splitlines()
    semicolons = [line.replace(",", ";").replace(".", ",") for line in lines]
    semicolons[0] = (
        "Nr;" + ";".join(f"Achse {k} [Grad]" for k in range(1, 7)) + ";Reflektor;X [mm];Y [mm];Z [mm];u [mm]"
    )
    semicolons[40] = semicolons[40].replace(",", ",x", 1)
    file = tmp_path / "messung.csv"
    file.write_bytes("\r\n".join(semicolons).encode("utf-16"))
    return file


def test_whoever_comes_first_is_told_what_this_is_and_shown_an_example(service, tablet):
    tablet.goto(service.url)
    expect(tablet.locator(".welcome .lead")).to_be_visible()
    expect(tablet.locator(".way li")).to_have_count(5)

    tablet.locator(".welcome [data-example]").click()

    tablet.wait_for_url("**/bring/1")
    expect(tablet.locator("[data-go]")).to_be_visible()


def test_somebody_who_has_never_seen_it_reads_the_cause_of_an_own_table(service, tablet, own_table):
    begun_s, taps = time.monotonic(), 2  # the button, and the dialogue's own
    tablet.goto(f"{service.url}/bring")
    tablet.set_input_files("[data-bring] input[multiple]", own_table)

    expect(tablet.locator("td[aria-invalid]")).to_be_visible()
    for answer in ("[data-leave-out]", '[data-day="0"]', "[data-go]"):
        tablet.locator(answer).click()
        taps += 1

    tablet.wait_for_url("**/diagnoses/*", timeout=MOST_S * 1000)
    expect(tablet.get_by_text("joint harmonics (joint 4)").first).to_be_visible()
    assert "SIMULATED" not in tablet.inner_text("body")
    assert taps <= MOST_TAPS
    assert time.monotonic() - begun_s < MOST_S
    tablet.goto(service.url)
    expect(tablet.locator("#latest")).to_be_visible()
    expect(tablet.locator(".welcome")).to_have_count(0)


@pytest.fixture
def asked(service, tablet, tmp_path):
    """The page of a table that says neither how uncertain its points are nor when they were measured."""
    lines = example_files()["left arm.csv"].decode().splitlines()
    (tmp_path / "bare.csv").write_text("\n".join(line.rsplit(",", 1)[0] for line in lines))
    tablet.goto(f"{service.url}/bring")
    tablet.set_input_files("[data-bring] input[multiple]", tmp_path / "bare.csv")
    expect(tablet.locator("[data-about]")).to_have_count(2)
    return tablet


@pytest.fixture
def today(asked):
    return asked.locator('[data-day="0"]')


@pytest.fixture
def uncertainty(asked):
    return asked.locator('[data-about="uncertainty"] button').first


def assert_chosen(button):
    expect(button).to_have_attribute("aria-pressed", "true")


# The place of a control at the moment that the page has been replaced, before anything else is loaded.
_PLACES = """selector => {
  window.places = [];
  const note = () => window.places.push(document.querySelector(selector).getBoundingClientRect().y);
  new MutationObserver(note).observe(document.querySelector("#draft").parentNode, { childList: true });
}"""


def test_an_answer_stays_until_it_is_changed_and_nothing_below_it_moves(asked, today, uncertainty):
    today.scroll_into_view_if_needed()
    uncertainty.scroll_into_view_if_needed()
    place = today.bounding_box()
    asked.evaluate(_PLACES, '[data-day="0"]')

    uncertainty.evaluate("button => button.click()")
    assert_chosen(uncertainty)

    assert asked.evaluate("window.places") == [place["y"]]
    assert today.bounding_box() == place
    asked.mouse.click(place["x"] + 9, place["y"] + 9)
    assert_chosen(today)
    assert_chosen(uncertainty)
    expect(asked.locator("[data-go]")).to_be_visible()

    asked.locator('[data-day="1"]').click()
    assert_chosen(asked.locator('[data-day="1"]'))
    expect(today).to_have_attribute("aria-pressed", "false")


def test_a_press_that_lasts_while_the_page_is_written_anew_is_a_tap(asked, today, uncertainty):
    today.scroll_into_view_if_needed()
    place = today.bounding_box()
    asked.mouse.move(place["x"] + 9, place["y"] + 9)

    with asked.expect_response("**/bring/*"):
        uncertainty.evaluate("button => button.click()")
        asked.mouse.down()
    asked.wait_for_timeout(300)
    asked.mouse.up()

    assert_chosen(today)
    assert_chosen(uncertainty)


def test_a_page_that_arrives_late_undoes_no_later_one(asked, today, uncertainty):
    late = []
    asked.route(
        "**/bring/*", lambda route: route.continue_() if late else late.append((route, route.fetch()))
    )
    uncertainty.click()
    while not late:
        asked.wait_for_timeout(20)

    today.click()
    assert_chosen(today)
    route, reply = late[0]
    route.fulfill(response=reply)

    asked.wait_for_timeout(300)
    assert_chosen(today)
    assert_chosen(uncertainty)
