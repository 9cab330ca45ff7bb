"""A person at the tablet: reads the screen, does what it asks with the simulated hands, taps."""

import contextlib
import time

from playwright.sync_api import TimeoutError

PATIENCE_S = 60.0  # with the next screen, on a busy machine
UNHEARD_S = 5.0  # after which the page has said that nobody heard
READ = ("initialise", "measure_side", "connect_leg")
DONE = ("place_base", "fit_ball", "clamp_cup", "remove_ball", "detach")


def acted(page, desk, n=1):
    """Wait until the desk has carried out `n` acts and return them."""
    for _ in range(500):
        if len(desk.acts) >= n:
            break
        page.wait_for_timeout(20)
    assert len(desk.acts) == n, desk.acts
    return desk.acts


def hold_long_enough(page):
    """Keep a finger on what is under it until the page takes it for held, however slow the machine is."""
    page.mouse.down()
    page.locator(".holding").wait_for(state="detached")
    page.mouse.up()


class Operator:
    def __init__(self, page):
        self.page = page
        self.seen = []  # (screen, step) as they came

    def screen(self):
        """Return the screen and what tells this step from the last one."""
        return self.page.evaluate(
            "[document.body.dataset.screen, document.querySelector('#where').textContent]"
        )

    def walk(self, until):
        """Go on until a screen of that name is there, or `until(screen, where)` says so."""
        reached = until if callable(until) else lambda screen, _: screen == until
        now = self.screen()
        while not reached(*now):
            self.seen.append(tuple(now))
            self._do(now[0])
            now = self._next(now)

    def _do(self, screen):
        if screen in READ:
            self.page.locator("[data-hand=asked]").click()
        elif screen in DONE:
            self.page.locator("[data-hand=asked]").click()
            self.page.locator("#actions button").click()
        elif screen == "move":
            self.hold()
        elif screen == "doubt":  # the lengths of the bench are those of no arm
            self.page.locator("#actions [data-act=answer]").last.click()
        elif screen == "paused" and self._skippable() and "pre-calibration failed" in self._panel():
            self.skip("Not possible with the equipment here")
        elif screen in {"planned", "paused", "interrupted"}:
            self.page.locator("#actions button").click()

    def _skippable(self):
        return self.page.locator(".dock [data-act=skip]").is_enabled()

    def _panel(self):
        return self.page.locator("#panel").inner_text()

    def skip(self, reason):
        """Leave the present step out."""
        self.page.get_by_role("button", name="Skip", exact=True).click()
        self.page.get_by_text(reason).click()
        self.page.get_by_role("button", name="Skip for this reason").click()

    def hold(self):
        """Keep a finger on the button that moves the robot."""
        self.page.locator("#actions button:enabled").hover()
        hold_long_enough(self.page)

    def _next(self, before):
        began = time.monotonic()
        end, again = began + PATIENCE_S, began + UNHEARD_S
        while (now := self.screen()) == before:
            assert time.monotonic() < end, (before, self.page.locator("body").inner_text())
            if before[0] == "move" and time.monotonic() > again:
                self._hold_again()
                again = time.monotonic() + UNHEARD_S
            self._say_how_off()
            self.page.wait_for_timeout(30)
        return now

    def _say_how_off(self):
        """Answer the page where nothing shows that the ballbar is off."""
        written = self.page.get_by_label("What you see")
        if written.is_visible():
            written.fill("It lies beside the arm.")
            self.page.get_by_role("button", name="The ballbar is off and out of the arm").click()

    def _hold_again(self):
        """Confirm once more where a busy service did not hear in time, if it is still asked for."""
        with contextlib.suppress(TimeoutError):
            self.page.locator("#actions button.hold:enabled").hover(timeout=500)
            hold_long_enough(self.page)
