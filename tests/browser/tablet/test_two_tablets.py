"""Two tablets may watch, one acts; the other one takes over with one confirmed tap."""

import pytest
from playwright.sync_api import expect

from tests.browser.tablet.conftest import a_tablet

CONTROLS = ("Back", "Retry", "Skip", "Pause", "Abort", "Store now")


@pytest.fixture
def both(chromium, desk, url):
    with a_tablet(chromium, url) as ada, a_tablet(chromium, url, person="Grace Hopper") as grace:
        for page in (ada, grace):
            page.goto(f"{url}/operator/3")
        ada.get_by_role("button", name="Store now").click()
        expect(ada.locator("#who")).to_contain_text("You have control")
        expect(grace.locator("#who")).to_contain_text("Ada Byron has control on another tablet")
        yield ada, grace


def test_only_the_acting_tablet_has_buttons_but_stop_is_everybodys(both):
    ada, grace = both

    for name in CONTROLS:
        expect(ada.get_by_role("button", name=name, exact=True)).to_be_enabled()
        expect(grace.get_by_role("button", name=name, exact=True)).to_be_disabled()
    for page in both:
        expect(page.get_by_role("button", name="STOP")).to_be_enabled()
    expect(ada.locator("#take-over")).to_be_hidden()
    for page in both:
        expect(page.locator("#length")).to_have_text("300.421 mm")


def test_a_takeover_may_be_thought_over_and_is_one_tap_and_one_confirmation(desk, both):
    ada, grace = both
    grace.get_by_role("button", name="Take over").click()
    grace.get_by_role("button", name="Cancel").click()
    expect(grace.locator("#who")).to_contain_text("Ada Byron has control")

    grace.get_by_role("button", name="Take over").click()
    expect(grace.locator("#dialogue")).to_contain_text("Ada Byron has control now")
    assert desk.carried_out("hand_over") == []
    grace.locator("#dialogue").get_by_role("button", name="Take over").click()

    expect(grace.locator("#who")).to_contain_text("You have control")
    expect(ada.locator("#who")).to_contain_text("Grace Hopper has control on another tablet")
    expect(ada.get_by_role("button", name="Store now")).to_be_disabled()
    expect(grace.get_by_role("button", name="Store now")).to_be_enabled()
    assert len(desk.carried_out("hand_over")) == 1
