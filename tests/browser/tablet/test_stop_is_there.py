"""STOP, and what confirms, at every size of screen, whatever is open: there, whole, under the finger."""

import pytest

from tests.browser.tablet.bench.fake_desk import move, scene
from tests.browser.tablet.conftest import a_tablet
from tests.browser.tablet.test_screens import SCREENS, shown

SIZES = [(320, 568), (390, 844), (844, 390), (1024, 600), (800, 1280), (1280, 800)]
NOTICES = """() => {
  for (const notice of document.querySelectorAll(".notice")) {
    notice.hidden = false;
    notice.textContent = "The service refused this because of something that is long to say. ".repeat(2);
  }
}"""
# What of these buttons is outside of the screen, or lies under something else at its middle or near a corner.
OUT_OF_REACH = """(selector) => {
  const reached = (button, x, y) => button.contains(document.elementFromPoint(x, y));
  return [...document.querySelectorAll(selector)].flatMap((button) => {
    const { left, right, top, bottom } = button.getBoundingClientRect();
    const name = button.textContent.trim();
    const whole = left >= 0 && top >= 0 && right <= innerWidth + 0.5 && bottom <= innerHeight + 0.5;
    if (!whole) return [`${name} sticks out`];
    const across = [left + 12, (left + right) / 2, right - 12];
    const down = [top + 12, (top + bottom) / 2, bottom - 12];
    const free = across.every((x) => down.every((y) => reached(button, x, y)));
    return free ? [] : [`${name} is covered`];
  });
}"""


@pytest.fixture(params=SIZES, ids=lambda size: "x".join(map(str, size)))
def a_screen(request, chromium, url):
    width, height = request.param
    with a_tablet(chromium, url, size={"width": width, "height": height}) as page:
        page.goto(f"{url}/operator/3")
        page.locator("#simulated").wait_for()
        yield page


def test_stop_and_what_confirms_can_be_pressed_on_every_screen_with_notices_open(desk, a_screen):
    wrong = {}
    for screen in SCREENS:
        shown(a_screen, desk, screen)
        a_screen.evaluate(NOTICES)
        found = a_screen.evaluate(OUT_OF_REACH, ".dock button, #actions button")
        wrong |= {screen: found} if found else {}

    assert wrong == {}


def test_stop_can_be_pressed_while_the_page_asks_something(desk, a_screen):
    shown(a_screen, desk, "connect_leg")

    a_screen.get_by_role("button", name="Skip").click()

    a_screen.locator("#dialogue").wait_for()
    assert a_screen.evaluate(OUT_OF_REACH, ".control.stop") == []


def test_stop_is_large_and_whole_words_are_on_the_controls(desk, a_screen):
    shown(a_screen, desk, "moving")

    heights = a_screen.locator(".dock button").evaluate_all("all => all.map(b => b.offsetHeight)")
    cut = a_screen.locator(".dock button").evaluate_all(
        "all => all.filter(b => b.scrollWidth > b.clientWidth + 1).map(b => b.textContent)"
    )
    assert min(heights) >= 48
    assert heights[-1] >= 64
    assert cut == []


def test_what_lies_between_can_be_scrolled_to_on_a_small_screen(desk, chromium, url):
    with a_tablet(chromium, url, size={"width": 320, "height": 568}) as page:
        page.goto(f"{url}/operator/3")
        desk.scene = scene()
        desk.show(step=move(), ballbar_attached=False)
        page.locator("body[data-screen=move]").wait_for()

        page.wait_for_timeout(300)  # the list is built anew with each thing that is told

        page.locator("#panel li").last.scroll_into_view_if_needed()

        assert page.locator("#panel li").last.is_visible()
        assert page.evaluate(OUT_OF_REACH, ".dock button, #actions button") == []
