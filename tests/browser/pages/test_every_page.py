"""Every page that the application has, of whatever record, held against what is promised of all of them."""

import contextlib

import pytest
from playwright.sync_api import expect

from tests.browser.pages.looks import LOOKS, Traffic, sticking_out, too_small, violations
from tests.browser.pages.shop import open_shop, pages
from tests.browser.windows import without_complaint
from tests.helpers.kept_sentences import KEPT
from truepose.words.catalogue import catalogue

TABLET, PHONE = {"width": 1180, "height": 820}, {"width": 390, "height": 844}
HEAVIEST = 400_000  # bytes
HEAVIER = {"/docs": 600_000}  # all of the interface on one page, for those who write programs


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    with open_shop(tmp_path_factory.mktemp("shop")) as url:
        yield url


@contextlib.contextmanager
def opened(chromium, shop, address):
    with chromium.one(shop, TABLET) as page, without_complaint(page, shop):
        traffic = Traffic(page)
        reply = page.goto(shop + address)
        page.locator("body:not([data-screen=loading])").wait_for()
        traffic.settled()
        assert reply.ok
        yield page, traffic
        traffic.close()


@pytest.mark.parametrize("address", pages())
def test_a_page_can_be_read_pressed_and_loaded_by_everybody(chromium, shop, address):
    with opened(chromium, shop, address) as (page, traffic):
        weight = traffic.weight
        small = too_small(page)
        page.set_viewport_size(PHONE)
        wide = sticking_out(page)
        found = {look: violations(page, look) for look in LOOKS}

    assert {look: told for look, told in found.items() if told} == {}
    assert small == []
    assert wide == []
    assert weight <= HEAVIER.get(address, HEAVIEST)


def test_units_are_chosen_once_for_the_pages_and_the_tablets(chromium, shop):
    with opened(chromium, shop, "/identifications/1?units=inch") as (page, _):
        page.locator("h1").first.wait_for()
        assert " in" in page.locator("main .cards").first.inner_text()
        page.locator(".menu:not(.person) summary").click()
        page.get_by_role("link", name="°F").click()
        chosen = page.locator("[aria-labelledby=menu-units] [aria-current]")
        expect(chosen).to_have_text(["inch", "degrees", "°F"])
        page.goto(f"{shop}/operator/3")
        page.locator("#units").get_by_text("in", exact=True).wait_for()


@pytest.mark.parametrize("language", ["de", "ja"])
def test_a_tablet_hears_what_the_service_keeps_as_its_pages_do(chromium, shop, language):
    hear = """async ([language, texts]) => {
      const { Stored } = await import("/static/stored.js");
      const stored = await Stored.load(language);
      return texts.map((text) => stored.pieces(text).map((piece) => [piece.text, piece.lang]));
    }"""
    with opened(chromium, shop, "/errors") as (page, _):
        heard = page.evaluate(hear, [language, list(KEPT)])

    for text, pieces in zip(KEPT, heard, strict=True):
        expected = [list(piece) for piece in catalogue(language).heard(text)]
        assert [lang for _, lang in pieces] == [lang for _, lang in expected], text
        assert ["".join(one.split()) for one, _ in pieces] == ["".join(one.split()) for one, _ in expected]
