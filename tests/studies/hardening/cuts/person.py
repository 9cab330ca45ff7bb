"""Somebody at a tablet who taps what can be tapped, whatever the network does, and remembers each tap."""

import asyncio
import contextlib
import time
from dataclasses import dataclass, field
from typing import Any, Final

import httpx
from playwright.async_api import Page, Request, TimeoutError

_FRAME_S: Final = 0.05
_HOLD_S: Final = 1.7
_FRESH_S: Final = 0.65  # the buttons of a new screen wait so long
NOW_SCREENS: Final = frozenset({"move", "interrupted", "foreign", "ask", "handwork"})
_READ: Final = frozenset({"initialise", "measure_side", "connect_leg"})
_DONE: Final = frozenset({"place_base", "fit_ball", "clamp_cup", "remove_ball", "detach"})
# One tap of a button that can be tapped; whatever the page then asks is answered with its first choice.
_TAP: Final = """(act) => {
  const all = [...document.querySelectorAll(`[data-act="${act}"]`)];
  const isThere = (one) => !one.disabled && one.getClientRects().length && !one.classList.contains("hold");
  const button = all.filter(isThere).at(-1);
  if (!button || !document.querySelector("#dialogue").hidden) return false;
  button.click();
  const form = document.querySelector("#dialogue form");
  const reason = form?.querySelector("input[type=radio]");
  const written = form?.querySelector("[name=written]");
  if (reason) reason.checked = true;
  else if (written) written.value = "It lies beside the arm.";
  form?.requestSubmit();
  return true;
}"""
# What the page asks by itself, or after a button was held: how one knows that the ballbar is off.
_ANSWER: Final = """() => {
  const form = document.querySelector("#dialogue:not([hidden]) form");
  const written = form?.querySelector("[name=written]");
  if (!written || form.querySelector("input[type=radio]")) return false;
  written.value = "It lies beside the arm.";
  form.requestSubmit();
  return true;
}"""
SAID: Final = """
window.said = [];
addEventListener("DOMContentLoaded", () => {
  const place = document.querySelector("#said");
  if (!place) return;
  const heard = () => place.hidden || !place.textContent || window.said.push(place.textContent);
  new MutationObserver(heard).observe(place, { childList: true, attributes: true });
});
"""


@dataclass(slots=True)
class Sent:
    """One tap on its way: all requests with its key."""

    key: str
    act: str
    begun_s: float
    held: bool  # let go of now or never
    under_way: int = 0
    statuses: list[int] = field(default_factory=list)


@dataclass(slots=True)
class Tap:
    """A finger on a button."""

    act: str
    screen: str
    at_s: float

    @property
    def is_queued(self) -> bool:
        """Whether the page keeps it until it is answered."""
        only_now = self.act in {"start", "resume"} or (self.act == "confirm" and self.screen in NOW_SCREENS)
        return not only_now


class Person:
    """Acts on one page, and follows what the page sends."""

    def __init__(self, page: Page, http: httpx.AsyncClient) -> None:
        self.page = page
        self.http = http  # to the service without the wire: the hands are no part of the network
        self.taps: list[Tap] = []
        self.sent: dict[str, Sent] = {}
        page.on("request", self._begun)
        page.on("response", self._answered)
        page.on("requestfailed", self._over)
        page.on("requestfinished", self._over)

    def _of(self, request: Request) -> Sent | None:
        if not request.url.endswith("/commands"):
            return None
        key = request.headers["idempotency-key"]
        body = request.post_data_json
        return self.sent.setdefault(key, Sent(key, body["command"], time.monotonic(), "prompt_id" in body))

    def _begun(self, request: Request) -> None:
        if (sent := self._of(request)) is not None:
            sent.under_way += 1

    def _answered(self, response: Any) -> None:
        if (sent := self._of(response.request)) is not None:
            sent.statuses.append(response.status)

    def _over(self, request: Request) -> None:
        if (sent := self._of(request)) is not None:
            sent.under_way -= 1

    async def screen(self) -> str:
        """Return what the page shows."""
        return str(await self.page.evaluate("document.body.dataset.screen"))

    async def tap(self, act: str) -> bool:
        """Tap a button if it can be tapped; returns whether it could."""
        screen, at_s = await self.screen(), time.monotonic()
        if not await self.page.evaluate(_TAP, act):
            return False
        self.taps.append(Tap(act, screen, at_s))
        await asyncio.sleep(_FRAME_S)  # a finger is no faster than the screen
        return True

    async def hold(self) -> None:
        """Hold the button that lets the arm move, as long as it wants to be held."""
        with contextlib.suppress(TimeoutError):
            await self.page.wait_for_selector("#actions .hold:enabled", timeout=1000 * _FRESH_S)
        box = await self.page.evaluate(
            "(() => { const b = document.querySelector('#actions .hold:enabled'); if (!b) return null;"
            " const r = b.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; })()"
        )
        if box is None:
            return
        await self.page.mouse.move(*box)
        await self.page.mouse.down()
        await asyncio.sleep(_HOLD_S)
        await self.page.mouse.up()
        await self._say_how_off()

    async def _say_how_off(self) -> None:
        """Answer what the page asks of a ballbar that may be attached; it then sends the tap anew."""
        screen, at_s = await self.screen(), time.monotonic()
        if await self.page.evaluate(_ANSWER):
            self.taps.append(Tap("confirm", screen, at_s))

    async def use_hands(self, path: str) -> None:
        """Do with the simulated hands what the step asks for."""
        step = (await self.http.get(path)).json().get("step") or {}
        if (action := _asked(step)) is not None:
            await self.http.post("/api/v1/simulated-hands", json=action)

    async def go_on(self, screen: str, path: str) -> None:
        """Do what the screen is for, once its buttons are taken for looked at."""
        await asyncio.sleep(_FRESH_S)
        await self._say_how_off()
        if screen in _READ | _DONE:
            await self.use_hands(path)
            await self.tap("store" if screen in _READ else "confirm")
        elif screen in {"move", "ask", "foreign"}:
            await self.hold()
        elif screen == "who":
            await self.page.evaluate("document.querySelector('[data-act=place]')?.click()")
        elif screen in {"planned", "place"}:
            await self.tap("start")
        elif screen == "doubt":
            await self.tap("answer")
        elif screen == "interrupted":
            await self.tap("confirm")
        elif screen == "paused":
            await self._resume()

    async def _resume(self) -> None:
        panel = await self.page.inner_text("#panel")
        if "pre-calibration failed" in panel and await self.tap("skip"):
            return
        if await self.page.query_selector("#actions .hold"):
            await self.hold()
        else:
            await self.tap("resume")


def _asked(step: dict[str, Any]) -> dict[str, Any] | None:
    a, b = (int(name[1:]) for name in step.get("points") or ("B0", "T0"))
    actions: dict[str, dict[str, Any]] = {
        "initialise": {"action": "calibrator", "bars": step.get("artefact")},
        "measure_side": {"action": "side", "artefact": step.get("artefact"), "a": a, "b": b},
        "place_base": {"action": "place_base", "placement": step.get("placement")},
        "fit_ball": {"action": "fit_ball"},
        "remove_ball": {"action": "remove_ball"},
        "clamp_cup": {"action": "clamp", "base_point": step.get("base_point")},
        "connect_leg": {"action": "connect", "base": a, "tool": b},
        "detach": {"action": "detach"},
    }
    return actions.get(str(step.get("kind")))
