"""A tablet's network is cut a thousand times while somebody taps: each tap counts once, none moves late.

    python -m tests.studies.hardening.cuts --cuts 1000 --out out/cuts

Ballbar and tracker sessions on the real service, in Chromium, over a wire that loses all, loses answers,
delivers late, or leaves what is open dead. The cells are in memory. What arrives, what the arm does and what
stands in the ledger is seen from outside, and compared with every tap.
"""

import asyncio
import contextlib
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Final

import httpx
import numpy as np
from playwright.async_api import Browser, async_playwright

from tests.browser.tablet.bench.wire import wire_to
from tests.studies.hardening.cuts.cells import BallbarCell, TrackerCell, end_all, watched
from tests.studies.hardening.cuts.lane import Lane, Tally
from tests.studies.hardening.cuts.person import SAID, Person
from tests.studies.running import study_options

_SIZE: Final = {"width": 1180, "height": 820}
_KEPT: Final = (
    "localStorage.getItem('truepose.person') ?? localStorage.setItem('truepose.person', 'Ada Byron')"
)
_ENDED: Final = frozenset({"finished", "aborted", "failed"})
_OPENED_MS: Final = 60_000


async def walk(browser: Browser, cell: Any, folder: Path, cuts: int, seed: int, tally: Tally) -> None:
    """Cut the network of one tablet so many times, in as many sessions as that takes."""
    with contextlib.ExitStack() as opened:
        url, onlooker = opened.enter_context(watched(cell, folder))
        wire, near = opened.enter_context(wire_to(url))
        context = await browser.new_context(viewport=_SIZE)
        await context.add_init_script(_KEPT)
        await context.add_init_script(SAID)
        async with httpx.AsyncClient(base_url=url, timeout=60) as http:
            person = Person(await context.new_page(), http)
            rng = np.random.default_rng(seed)
            lane = Lane(person, wire, onlooker, folder / "t.sqlite3", rng, tally)
            for _ in range(cuts):
                if not lane.path or await person.screen() in _ENDED:
                    await _opened(lane, cell, url, near)
                await lane.cut_once()
        tally.motions += len(onlooker.sent_s)
        tally.stale.extend(onlooker.moved_unasked(each=cell.each_motion))
        await context.close()
        await asyncio.to_thread(end_all, url)


async def _opened(lane: Lane, cell: Any, url: str, near: str) -> None:
    id = await asyncio.to_thread(cell.plan, url)
    lane.path = f"/api/v1/sessions/{id}"
    lane.tally.sessions += 1
    await lane.person.page.goto(f"{near}/operator/{id}")
    await lane.person.page.wait_for_selector("#link[data-state=up]", timeout=_OPENED_MS)


async def study(cuts: int, lanes: int, seed: int, folder: Path) -> Tally:
    """Share the cuts among lanes, every other one with a tracker."""
    tally = Tally()
    path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=path, args=["--no-sandbox", "--disable-gpu"]
        )
        walks = [
            walk(
                browser,
                (BallbarCell, TrackerCell)[k % 2](),
                folder / str(k),
                cuts // lanes + (k < cuts % lanes),
                seed + k,
                tally,
            )
            for k in range(lanes)
        ]
        await asyncio.gather(*walks)
        await browser.close()
    return tally


def main() -> int:
    """Run the study and write what it found."""
    wanted = study_options(__doc__, cuts=1000, lanes=6, seed=0, out=Path("out/cuts"))
    wanted.out.mkdir(parents=True, exist_ok=True)
    began_s = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        tally = asyncio.run(study(wanted.cuts, wanted.lanes, wanted.seed, Path(folder)))
    (wanted.out / "cuts.json").write_text(tally.written())
    cuts, lasted_s = sum(tally.cuts.values()), time.monotonic() - began_s
    sys.stdout.write(f"{tally.written()}\n{cuts} cuts in {lasted_s:.0f} s, faults {len(tally.faults)}\n")
    return 1 if tally.faults or not tally.cuts else 0


if __name__ == "__main__":
    sys.exit(main())
