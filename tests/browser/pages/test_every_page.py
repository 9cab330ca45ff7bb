"""Every page that the application has, of whatever record, held against what is promised of all of them."""

import contextlib
import re

import httpx
import pytest
from playwright.sync_api import expect

from tests.browser.pages.house import OF_LINKS, SIGNED_IN, open_house
from tests.browser.pages.looks import Traffic, sticking_out, too_small, violations
from tests.browser.pages.shop import open_shop, pages
from tests.browser.windows import without_complaint

TABLET, PHONE = {"width": 1180, "height": 820}, {"width": 390, "height": 844}
DESKTOP = {"width": 1440, "height": 900}
HEAVIEST = 400_000  # bytes
_STATUS = "Failed to load resource: the server responded with a status of"
REFUSED = {"/not-yours": [f"{_STATUS} 403"]}
RESULTS = {f"/{kind}/1" for kind in ("identifications", "diagnoses", "validations", "models")}
# Pages that are read in another language than English: each language once with tables and figures.
READ_IN = {
    "/reports/identification/1": "de",
    "/reports/validation/1": "es",
    "/reports/diagnosis/1": "fr",
    "/sessions/2/result": "fr",
    "/corrections/1": "fr",
    "/plan": "fr",
}
POINT_IN_A_CELL = re.compile(r'class="n">[^<\w]*\d+\.\d[^<]*|>[^<\w]*\d+\.\d+</text>')


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    with open_shop(tmp_path_factory.mktemp("shop")) as url:
        yield url


@pytest.fixture(scope="module")
def house(tmp_path_factory):
    with open_house(tmp_path_factory.mktemp("house")) as opened:
        yield opened


@contextlib.contextmanager
def opened(chromium, url, address, cookies=(), allowed=()):
    with chromium.one(url, TABLET) as page, without_complaint(page, url, allowed):
        page.context.add_cookies(list(cookies))
        traffic = Traffic(page)
        reply = page.goto(address)
        page.locator("body:not([data-screen=loading])").wait_for()
        traffic.settled()
        page.locator("[data-drawing]").wait_for(state="detached")
        assert reply.ok or allowed
        yield page, traffic
        traffic.close()


def assert_held(page, traffic):
    """Hold a page against everything that is promised of all."""
    assert traffic.weight <= HEAVIEST
    assert too_small(page) == []
    assert page.evaluate("document.styleSheets.length") > 0
    assert page.evaluate("[...document.styleSheets].every((sheet) => sheet.cssRules.length > 0)")
    page.set_viewport_size(PHONE)
    assert sticking_out(page) == []
    assert violations(page) == []


def in_language(language, url):
    return [{"name": "language", "value": language, "url": url}]


# What is wholly on the screen, as it is before anybody scrolls.
_IN_SIGHT = """nodes => nodes.filter((node) => {
  const { top, bottom, height } = node.getBoundingClientRect();
  return height > 0 && top >= 0 && bottom <= innerHeight; }).map((node) => node.innerText)"""


def assert_first_screen(page):
    """The first screen of a result has its sentence, its figures and the next step."""
    page.set_viewport_size(DESKTOP)
    (outcome,) = page.locator(".outcome").evaluate_all(_IN_SIGHT)
    assert re.search(r"before \(nominal\), \d.* mm after", outcome)
    assert len(page.locator(".next-step .main").evaluate_all(_IN_SIGHT)) == 1


def assert_decimal_commas(html, *, pictures):
    """Tables and figures have the decimal comma of their language."""
    assert POINT_IN_A_CELL.findall(html) == []
    assert not pictures or re.search(r"\d,\d+</text>", html)
    assert not pictures or re.search(r'class="n">\d,\d', html)


@pytest.mark.parametrize("address", pages())
def test_a_page_can_be_read_pressed_and_loaded_by_everybody(chromium, shop, address):
    language = READ_IN.get(address, "en")
    with opened(chromium, shop, shop + address, in_language(language, shop)) as (page, traffic):
        if language != "en":
            assert page.locator("html").get_attribute("lang") == language
            assert_decimal_commas(page.content(), pictures=address.startswith("/reports/"))
        if address in RESULTS:
            assert_first_screen(page)
        assert_held(page, traffic)


def test_so_can_one_of_a_record_that_is_not_there(chromium, shop):
    with opened(chromium, shop, f"{shop}/diagnoses/99", allowed=[f"{_STATUS} 404"]) as shown:
        assert_held(*shown)


@pytest.mark.parametrize("place", SIGNED_IN)
def test_so_can_a_page_of_somebody_who_has_signed_in(chromium, house, place):
    with opened(chromium, house.url, house.address(place), house.cookies, REFUSED.get(place, ())) as shown:
        assert_held(*shown)


@pytest.mark.parametrize("place", OF_LINKS)
def test_so_can_a_page_of_whoever_has_a_link(chromium, house, place):
    with opened(chromium, house.url, house.address(place)) as shown:
        assert_held(*shown)


def test_so_can_the_page_on_which_the_first_person_is_entered(chromium, shop):
    (way,) = set(re.findall(r"/first-person/[\w-]+", httpx.get(shop, trust_env=False).text))

    with opened(chromium, shop, shop + way) as shown:
        assert_held(*shown)


def test_units_are_chosen_once_for_the_pages_and_the_tablets(chromium, shop, empty_pictures):
    with opened(chromium, shop, f"{shop}/identifications/1?units=inch") as (page, _):
        page.locator("h1").first.wait_for()
        assert " in" in page.locator("main .cards").first.inner_text()
        page.locator(".menu:not(.person) summary").click()
        page.get_by_role("link", name="°F").click()
        chosen = page.locator("[aria-labelledby=menu-units] [aria-current]")
        expect(chosen).to_have_text(["inch", "degrees", "°F"])
        page.goto(f"{shop}/operator/3")
        page.locator("#units").get_by_text("in", exact=True).wait_for()


def test_a_part_that_is_not_drawn_is_asked_for_again_and_a_refusal_is_said(chromium, shop):
    address = f"{shop}/models/1"
    whole = httpx.get(f"{address}?whole=true", trust_env=False).text
    waits = '<p role="status"></p><script type="module" src="/static/drawn.js"></script>'
    early = whole.replace('<div id="drawn">', f'<div id="drawn" data-drawing data-unreachable="">{waits}')
    answers = iter([(503, "Others draw."), (409, "Its readings are gone.")])

    def refuse(route):
        status, detail = next(answers)
        route.fulfill(status=status, json={"detail": detail})

    with chromium.one(shop, TABLET) as page:
        page.route(address, lambda route: route.fulfill(body=early, content_type="text/html"))
        page.route(f"{address}?whole=true", refuse)
        page.goto(address)

        expect(page.locator("[data-drawing] [role=status]")).to_have_text("Its readings are gone.")
