"""STOP at every size of screen, whatever is open: there, whole, under the finger (see `test_screens` too)."""

from tests.browser.tablet.bench.fake_desk import move, scene
from tests.browser.tablet.bench.screens import OUT_OF_REACH, SIZES, resized, shown


def test_stop_is_large_and_whole_words_are_on_the_controls(desk, tablet):
    shown(tablet, desk, "moving")

    controls = tablet.locator(".dock button")
    for size in SIZES:
        resized(tablet, size)
        heights = controls.evaluate_all("all => all.map(b => b.offsetHeight)")
        cut = controls.evaluate_all(
            "all => all.filter(b => b.scrollWidth > b.clientWidth + 1).map(b => b.textContent)"
        )
        assert min(heights) >= 48, size
        assert heights[-1] >= 64, size
        assert cut == [], size


def test_stop_can_be_pressed_while_the_page_asks_something(desk, tablet):
    shown(tablet, desk, "connect_leg")
    for size in SIZES:
        resized(tablet, size)
        tablet.get_by_role("button", name="Skip").click()
        tablet.locator("#dialogue").wait_for()

        assert tablet.evaluate(OUT_OF_REACH, ".control.stop") == [], size
        tablet.get_by_role("button", name="Cancel").click()
        tablet.locator("#dialogue").wait_for(state="hidden")


def test_what_lies_between_can_be_scrolled_to_on_a_small_screen(desk, tablet):
    resized(tablet, min(SIZES))
    desk.scene = scene()
    desk.show(step=move(), ballbar_attached=False)
    tablet.locator("body[data-screen=move]").wait_for()

    tablet.wait_for_timeout(300)  # the list is built anew with each thing that is told

    tablet.locator("#panel li").last.scroll_into_view_if_needed()

    assert tablet.locator("#panel li").last.is_visible()
    assert tablet.evaluate(OUT_OF_REACH, ".dock button, #actions button") == []
