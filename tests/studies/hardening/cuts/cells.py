"""A ballbar's and a tracker's cell in memory, each behind the real service, a wire and an onlooker."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import httpx

from tests.browser.tablet.bench.guided_bench import BriskClock, GuidedBench
from tests.browser.tablet.bench.guided_bench import plan as plan_tracker
from tests.browser.tablet.bench.working_bench import BusyHands, ConnectedBallbar, WorkingBench
from tests.browser.tablet.bench.working_bench import plan as plan_ballbar
from tests.integration.web.ballbar_bench import BALLBAR
from tests.integration.web.bench import CELL, FakeRobot
from tests.integration.web.listening import listening
from tests.studies.hardening.cuts.onlooker import Onlooker
from truepose.app import create_app
from truepose.settings import Settings

_PACE: Final = 3  # the cells' clocks run so much faster than the person's
_CONFIGURATIONS: Final = 60


class BallbarCell:
    """A cell whose hands put the ballbar where the step asks for it."""

    name = "ballbar"
    each_motion = True  # a person confirms each

    def __init__(self) -> None:
        self.bench = WorkingBench()
        self.bench.clock = BriskClock(_PACE)
        self.bench.ballbar = ConnectedBallbar(self.bench.clock)
        self.bench.hands = BusyHands(self.bench.ballbar)
        self.bench.robot = FakeRobot(self.bench.clock)
        self.cell = CELL + BALLBAR

    def plan(self, url: str) -> int:
        """Plan a session and return its number."""
        return int(plan_ballbar(url))


class TrackerCell:
    """A cell whose session runs by itself."""

    name = "tracker"
    each_motion = False

    def __init__(self) -> None:
        self.bench = GuidedBench(_PACE)
        self.cell = CELL

    def plan(self, url: str) -> int:
        """Plan a session and return its number."""
        return int(plan_tracker(url, _CONFIGURATIONS, reference_every=_CONFIGURATIONS))


@contextlib.contextmanager
def watched(cell: Any, folder: Path) -> Iterator[tuple[str, Onlooker]]:
    """Serve a cell; yields its URL and who looks on."""
    folder.mkdir(parents=True)
    (folder / "cell.toml").write_text(cell.cell)
    where = Settings(database_url=f"sqlite:///{folder}/t.sqlite3", cell_file=folder / "cell.toml")
    onlooker = Onlooker(create_app(where, cell.bench.registry()))
    onlooker.watch(cell.bench.robot)
    with listening(onlooker) as url:
        httpx.get(f"{url}/health", timeout=60)  # two databases cannot be made at once in one process
        yield url, onlooker


def end_all(url: str) -> None:
    """End whatever session is under way."""
    for session in httpx.get(f"{url}/api/v1/sessions?limit=100", timeout=60).json():
        if session["state"] not in {"finished", "aborted", "failed"}:
            end = {"command": "abort"}
            httpx.post(f"{url}/api/v1/sessions/{session['id']}/commands", json=end, timeout=60)
