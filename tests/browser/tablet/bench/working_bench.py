"""The real service on fake devices that answer each other: what the hands do is what the ballbar shows."""

import asyncio
import contextlib
import math
import time

import httpx

from tests.integration.web.ballbar_bench import BALLBAR, PLACEMENT, SESSIONS
from tests.integration.web.bench import CELL, Bench, FakeBallbar, FakeHands, FakeRobot
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.settings import Settings
from truepose_drivers.api import BallbarReading

PACE = 8  # the clock of the cell runs so much faster than the person who waits for it
PATIENCE_S = 60.0  # with an answer, on a busy machine
ONE_POSE = {**PLACEMENT, "poses": PLACEMENT["poses"][:1]}


class QuickClock:
    async def now_s(self):
        return time.monotonic() * PACE

    async def sleep(self, duration_s):
        await asyncio.sleep(duration_s / PACE)

    @property
    def time_s(self):
        return time.monotonic() * PACE


class ConnectedBallbar(FakeBallbar):
    """Shows what it is attached to; nothing while it lies aside."""

    def __init__(self, clock):
        super().__init__(clock)
        self.deviation_mm = None

    async def read(self):
        await asyncio.sleep(0.001)
        if self.deviation_mm is None:
            return BallbarReading(math.nan, "none", 1e-4, self._clock.time_s, 23.0)
        beyond = abs(self.deviation_mm) > 1.0
        signal = "out_of_range" if beyond else "good"
        return BallbarReading(self.deviation_mm, signal, 1e-4, self._clock.time_s, 23.0)


class BusyHands(FakeHands):
    """Puts the ballbar where it is told to; every pair has a length of its own."""

    def __init__(self, ballbar):
        super().__init__()
        self._ballbar = ballbar

    async def do(self, action, details):
        await super().do(action, details)
        taken = {
            "calibrator": lambda: 0.022 if details["bars"] == "tool" else 0.002,
            "side": lambda: 0.05 * details["a"] - 0.03 * details["b"],
            "connect": lambda: 0.31 * details["base"] - 0.17 * details["tool"],
            "detach": lambda: None,
        }
        if action in taken:
            self._ballbar.deviation_mm = taken[action]()


class WorkingBench(Bench):
    def __init__(self):
        super().__init__()
        self.clock = QuickClock()
        self.ballbar = ConnectedBallbar(self.clock)
        self.hands = BusyHands(self.ballbar)
        self.robot = FakeRobot(self.clock)


@contextlib.contextmanager
def serving(folder, bench):
    """Run the service on a database and a bench; yields its URL."""
    (folder / "cell.toml").write_text(CELL + BALLBAR)
    where = Settings(database_url=f"sqlite:///{folder}/t.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, bench.registry())) as url:
        yield url


def plan(url, name="left arm"):
    """Plan a session of one pose and return its number."""
    wanted = {"kind": "ballbar", "name": name, "placements": [ONE_POSE]}
    reply = httpx.post(f"{url}{SESSIONS}", json=wanted, timeout=PATIENCE_S)
    assert reply.status_code == 201, reply.text
    return reply.json()["id"]


def ledger(url, id):
    return httpx.get(f"{url}{SESSIONS}/{id}/ledger?limit=1000", timeout=PATIENCE_S).json()["entries"]


def shown(url, id):
    return httpx.get(f"{url}{SESSIONS}/{id}/situation", timeout=PATIENCE_S).json()
