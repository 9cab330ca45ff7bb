"""The real service on a tracker that sees a reflector a little beside where it is expected, and shows it."""

import asyncio
import contextlib
import time

import httpx
import numpy as np

from tests.browser.tablet.bench.working_bench import PATIENCE_S
from tests.integration.web.bench import CELL, Bench, FakeRobot, FakeTracker, session_request
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.settings import Settings
from truepose_drivers.api import TrackerReading
from truepose_drivers.errors import BeamBrokenError, ReflectorNotFoundError

ARM_OFF_MM = (0.412, -1.032, 0.633)  # what there is to calibrate
NOISE_MM = 0.0005
FIXED = 1.0  # a reflector so near a fixed nest [mm] is in it


LONGEST_STALL_S = 1.0  # half of what a robot's statement may be old


class BriskClock:
    """Runs faster than the person who looks on; `pace` may be set to see one step for long.

    A machine that stands still for a moment is no robot that is silent for as many times the pace: everybody
    who waits on this clock reads it often, so a long pause between two reads is the machine's own.
    """

    def __init__(self, pace):
        self.pace = pace
        self._passed_s, self._since_s = 0.0, time.monotonic()

    @property
    def time_s(self):
        now_s = time.monotonic()
        self._passed_s += min((now_s - self._since_s) * self.pace, LONGEST_STALL_S)
        self._since_s = now_s
        return self._passed_s

    async def now_s(self):
        return self.time_s

    async def sleep(self, duration_s):
        await asyncio.sleep(duration_s / self.pace)


class ShowingTracker(FakeTracker):
    """Scatters a little; sees nothing while somebody stands in the beam."""

    def __init__(self, clock):
        super().__init__(clock)
        self.beam_cut = False
        self._rng = np.random.default_rng(3)
        self._nests = np.array([[600.0, -500.0, 0.0], [600.0, 500.0, 0.0], [-350.0, 500.0, 0.0]])

    async def find_reflector(self, near_mm, *, search_radius_mm):
        await super().find_reflector(near_mm, search_radius_mm=search_radius_mm)
        if self.beam_cut:
            raise ReflectorNotFoundError("No reflector was found within 10 mm.")
        on_the_arm = np.linalg.norm(self._nests - near_mm, axis=1).min() > FIXED
        self._aimed_at = tuple(np.add(near_mm, ARM_OFF_MM if on_the_arm else 0.0).tolist())

    async def measure_point(self, *, duration_s):
        await self._clock.sleep(duration_s)
        if self.beam_cut:
            raise BeamBrokenError("The beam is broken.")
        return TrackerReading(
            self._seen(), (0.01,) * 3, 0.01, 100, duration_s, self._face, self._clock.time_s
        )

    async def reflector_now(self):
        return None if self._aimed_at is None or self.beam_cut else self._seen()

    def _seen(self):
        return tuple((np.array(self._aimed_at) + NOISE_MM * self._rng.standard_normal(3)).tolist())


class GuidedBench(Bench):
    def __init__(self, pace=40):
        super().__init__()
        self.clock = BriskClock(pace)
        self.tracker = ShowingTracker(self.clock)
        self.robot = FakeRobot(self.clock)


@contextlib.contextmanager
def serving(folder, bench):
    """Run the service on a database and a bench; yields its URL."""
    (folder / "cell.toml").write_text(CELL)
    where = Settings(database_url=f"sqlite:///{folder}/t.sqlite3", cell_file=folder / "cell.toml")
    with listening(create_app(where, bench.registry())) as url:
        yield url


def plan(url, n=4, **changes):
    """Plan a session with a tracker and return its number."""
    reply = httpx.post(f"{url}/api/v1/sessions", json=session_request(n, **changes), timeout=PATIENCE_S)
    assert reply.status_code == 201, reply.text
    return reply.json()["id"]


def guide(url, id):
    return httpx.get(f"{url}/api/v1/sessions/{id}/situation", timeout=PATIENCE_S).json()


def until(url, id, holds):
    """Return where a session stands once that holds."""
    end = time.monotonic() + PATIENCE_S
    while not holds(found := guide(url, id)):
        assert time.monotonic() < end, found
        time.sleep(0.02)
    return found
