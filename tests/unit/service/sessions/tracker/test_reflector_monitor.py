"""What whoever watches sees of the reflector; nobody who does not watch costs the tracker a question."""

import asyncio
import math
from dataclasses import replace

import pytest

from tests.helpers.domain import asking
from tests.unit.service.sessions.tracker.fakes import FakeCell, FakeTracker, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, begun, run_session
from truepose.domain.session import SessionState
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.errors import ConnectionLostError, NoReplyError
from truepose_drivers.guard import guarded


class ShowingTracker(FakeTracker):
    """Says where the reflector is as well."""

    looks = 0
    broken = False

    async def reflector_now(self):
        type(self).looks += 1
        if self.broken:
            raise ConnectionLostError("nobody is there")
        if self._locked is None:
            return None
        return tuple(self.in_tracker(self._reflectors())[self._locked].tolist())


@pytest.fixture
def cell(monkeypatch):
    monkeypatch.setattr("tests.unit.service.sessions.tracker.fakes.FakeTracker", ShowingTracker)
    monkeypatch.setattr(ShowingTracker, "looks", 0)
    return FakeCell()


async def seen_at(cell, where):
    """Halt a session where the arm sets out to a stop, and return what is seen then."""
    runner, running = await begun(cell, make_plan(2))
    shown = []

    async def watch():
        async for sighting in runner.live():
            shown.append(sighting)

    async def stand():
        if len(cell.robot.moves) == where:
            shown.clear()
            while len(shown) < 2:
                await asyncio.sleep(0.1)

    cell.robot.before_move = stand
    watching = asyncio.create_task(watch())
    await asking.confirm(runner, "Eva")
    assert await running is SessionState.FINISHED
    await asyncio.wait_for(watching, 60)  # it ends with the session
    return shown[0] if where is not None else None


async def test_the_way_still_to_go_is_shown_while_the_arm_moves(cell):
    sighting = await seen_at(cell, 2)  # on the way to the second stop; locked on the arm since the first

    assert sighting.is_seen
    assert sighting.is_moving
    assert sighting.state == "far"
    assert sighting.aim.config == 2
    assert sighting.distance_mm == pytest.approx(math.hypot(*sighting.delta_mm))


async def test_a_reflector_that_nobody_sees_is_no_number(cell):
    cell.tracker.broken = True

    sighting = await seen_at(cell, 2)

    assert (sighting.is_seen, sighting.delta_mm, sighting.state) == (False, None, "no_signal")


async def test_nobody_watches_and_nothing_is_asked(cell):
    await run_session(cell, make_plan(2))

    assert ShowingTracker.looks == 0


class BadlyDrivenTracker(FakeTracker):
    """Measures well; what its driver offers besides goes wrong each time in another way."""

    way = ""
    looks = 0
    is_over = False

    @property
    def settings(self):
        raise KeyError("reflector")

    @settings.setter
    def settings(self, value):
        pass

    async def reflector_now(self):
        self.looks += 1
        return await getattr(self, self.way)()

    async def fails(self):
        raise ValueError("could not convert string to float: '--'")

    async def says_nothing(self):
        self.connected = False
        raise NoReplyError("no answer within 1 s")

    async def hangs(self):
        await asyncio.Event().wait()

    async def hangs_whatever_is_wanted(self):
        while not self.is_over:
            try:
                await asyncio.sleep(1.0)
            except asyncio.CancelledError:
                continue

    async def answers_no_place(self):
        return "somewhere"

    async def answers_no_number(self):
        return (math.nan,) * 3


WAYS = ["fails", "says_nothing", "hangs", "hangs_whatever_is_wanted", "answers_no_place", "answers_no_number"]


@pytest.mark.simulated_time
@pytest.mark.parametrize("way", WAYS)
async def test_looking_on_with_a_driver_that_goes_wrong_ends_no_measurement(way, monkeypatch):
    monkeypatch.setattr("tests.unit.service.sessions.tracker.fakes.FakeTracker", BadlyDrivenTracker)
    cell = FakeCell()
    tracker = cell.tracker
    tracker.way = way
    cell.cell = replace(cell.cell, tracker=guarded("acme", "tracker", tracker))
    shown = []

    async def watch(runner):
        async for sighting in runner.live():
            shown.append(sighting)

    async def take_time():
        await asyncio.sleep(20.0)

    cell.robot.before_move = take_time
    runner = TrackerRunner(make_plan(6), cell.cell, cell.journal)
    watching = asyncio.create_task(watch(runner))
    running = asyncio.create_task(runner.run())
    operator = PatientOperator(look_s=1.0)

    assert await operator.attend(runner, running) is SessionState.FINISHED
    tracker.is_over = True

    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4, 5, 6]
    await asyncio.wait_for(watching, 60.0)
    assert not any(sighting.is_seen for sighting in shown)
    if way != "answers_no_number":  # which costs nothing, and may be asked again
        assert tracker.looks == 1
    assert len(operator.questions) <= 2  # the first, and one where the look has cost the link
