"""Whatever persons ask and whatever fails, in any order: nothing moves that must not."""

import asyncio
import contextlib
from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.domain import asking
from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.tracker.fakes import FakeCell, ListLedger, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.session import SessionState
from truepose.sessions.engine.interlocks import MAX_STATE_AGE_S
from truepose.sessions.engine.states import has_ended
from truepose.sessions.errors import NotNowError
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.errors import ConnectionLostError

N_STOPS = 4


class SlowLedger(ListLedger):
    """Lets others run before and after each record, as a disk does."""

    async def append(self, entry):
        await asyncio.sleep(0)
        number = await super().append(entry)
        await asyncio.sleep(0)
        return number


class Guard:
    """Watches every motion from outside, with its own book of what was asked and what failed."""

    def __init__(self, cell: FakeCell) -> None:
        self.cell = cell
        self.plan = make_plan(N_STOPS, registration_readings=2)
        self.runner = TrackerRunner(self.plan, cell.cell, cell.journal)
        self.running = asyncio.create_task(self.runner.run())
        self.stop_asked = False
        self.confirmed_since_fault = False
        self.read_at_s: float | None = None
        self.motions = 0
        self._move = cell.robot.move_joints
        self._read = cell.robot.read_joints
        cell.robot.move_joints = self.move
        cell.robot.read_joints = self.read

    async def read(self):
        reading = await self._read()
        self.read_at_s = reading.time_s
        await asyncio.sleep(0)  # the answer is under way: others act meanwhile
        return reading

    async def move(self, target):
        self.motions += 1
        assert self.runner.state is SessionState.RUNNING
        entered, _, person = self.cell.journal.states[-1]
        assert entered is SessionState.RUNNING, "the record lags behind the motion"
        assert person == "Eva"
        assert self.runner.prompt is None
        assert not self.stop_asked
        assert self.confirmed_since_fault
        assert self.cell.robot.connected
        assert self.read_at_s is not None
        assert self.cell.clock.time_s - self.read_at_s <= MAX_STATE_AGE_S
        await asyncio.sleep(0)  # the motion takes a while: others act meanwhile
        await self._move(target)
        await asyncio.sleep(0)

    async def act(self, action: str) -> None:
        with contextlib.suppress(NotNowError):
            await getattr(self, action)()

    async def pause(self):
        if self.runner.state is SessionState.RUNNING:
            self.stop_asked = True
        await asking.pause(self.runner, "Eva")

    async def abort(self):
        self.stop_asked = True
        await asking.end(self.runner, "Eva")

    async def resume(self):
        await self._allow(asking.resume)

    async def confirm(self):
        await self._allow(asking.confirm)

    async def _allow(self, go_on):
        allowed_before = self.stop_asked, self.confirmed_since_fault
        # the answer counts from the moment it is on record, which is inside the call
        self.stop_asked = self.stop_asked and self.runner.state is SessionState.RUNNING
        self.confirmed_since_fault = True
        try:
            await go_on(self.runner, "Eva")
        except NotNowError:
            self.stop_asked, self.confirmed_since_fault = allowed_before
            raise

    async def lose_robot(self):
        if self.cell.robot.connected:  # a link that is not up yet cannot be lost
            self.cell.robot.connected = False
            self.confirmed_since_fault = False

    async def lose_tracker(self):
        original = self.cell.tracker.measure_point

        async def lose(*, duration_s):
            self.cell.tracker.measure_point = original
            self.cell.tracker.connected = False
            raise ConnectionLostError("the tracker is gone")

        self.cell.tracker.measure_point = lose

    async def lose_clock(self):
        original = self.cell.clock.now_s

        async def lose():
            self.cell.clock.now_s = original
            raise ConnectionLostError("the clock is gone")

        self.cell.clock.now_s = lose

    async def go_blind(self):
        self.cell.tracker.blind = True

    async def see(self):
        self.cell.tracker.blind = False

    async def grow_stale(self):
        self.cell.robot.reading_age_s = 3.0

    async def grow_fresh(self):
        self.cell.robot.reading_age_s = 0.0

    async def restart(self):
        """Kill the service wherever it is, and have another one take up what is on the disk."""
        self.running.cancel()
        await asyncio.gather(self.running, return_exceptions=True)
        self.confirmed_since_fault = False
        self.stop_asked = False
        await self.cell.tracker.close()
        await self.cell.robot.close()
        entries = tuple(self.cell.journal.entries)
        self.runner = TrackerRunner(self.plan, self.cell.cell, self.cell.journal, entries)
        self.running = asyncio.create_task(self.runner.run())

    async def jog(self):
        self.cell.robot.joints = tuple(joint + 0.05 for joint in self.cell.robot.joints)


REQUESTS = ("pause", "abort", "resume", "confirm", "resume", "confirm")
LOSSES = ("restart", "lose_robot", "lose_tracker", "lose_clock")
FAULTS = (*LOSSES, "go_blind", "see", "grow_stale", "grow_fresh", "jog")
ACTIONS = st.sampled_from((*REQUESTS, *FAULTS))
SCRIPTS = st.lists(st.tuples(st.integers(0, 12), ACTIONS), max_size=14)  # turns of the loop between two


async def play(script):
    cell = FakeCell()
    cell.journal = SlowLedger()
    guard = Guard(cell)
    while guard.runner.state is not SessionState.AWAITING_CONFIRMATION:
        await asyncio.sleep(0)
    for turns, action in ((0, "confirm"), *script):
        for _ in range(turns):
            await asyncio.sleep(0)
        await guard.act(action)
    await guard.see()
    await guard.grow_fresh()
    ended = await finish(guard)
    return cell, guard, ended


async def finish(guard):
    """Answer all questions that are left, ten at most, and end the session after that."""
    answers = 0
    async with asyncio.timeout(HANGS_S):
        while not guard.running.done():
            await asyncio.sleep(0)
            if guard.runner.prompt is None:
                continue
            answers += 1
            await guard.act("abort" if answers > 200 else "confirm")
            await guard.act("resume")
    return guard.running.result()


@settings(max_examples=100, deadline=None)
@given(SCRIPTS)
def test_no_script_of_requests_and_faults_moves_the_robot_when_it_must_not(script):
    cell, _, ended = asyncio.run(play(script))

    assert has_ended(ended)
    stored = Counter(point.config for point in cell.journal.points)
    left_out = Counter(skipped.config for skipped in cell.journal.skipped)
    assert all(count == 1 for count in (stored + left_out).values())
    if ended is SessionState.FINISHED:
        assert set(stored) | set(left_out) == set(range(1, N_STOPS + 1))


async def test_the_guard_itself_sees_motions():
    cell, guard, ended = await play([])

    assert ended is SessionState.FINISHED
    assert guard.motions == 2 * N_STOPS
    assert len(cell.journal.points) == N_STOPS


async def test_the_guard_notices_a_motion_without_confirmation():
    guard = Guard(FakeCell())

    with pytest.raises(AssertionError):
        await guard.move((0.0,) * 6)


async def asking_on_a_slow_disk():
    cell = FakeCell()
    cell.journal = SlowLedger()
    runner = TrackerRunner(make_plan(), cell.cell, cell.journal)
    running = asyncio.create_task(runner.run())
    while runner.state is not SessionState.AWAITING_CONFIRMATION:
        await asyncio.sleep(0)
    return cell, runner, running


async def test_an_abort_during_a_confirmation_wins():
    cell, runner, running = await asking_on_a_slow_disk()

    await asyncio.gather(asking.confirm(runner, "Eva"), asking.end(runner, "Adam"))

    assert await running is SessionState.ABORTED
    assert cell.robot.moves == []


async def test_of_two_confirmations_one_is_refused():
    _, runner, running = await asking_on_a_slow_disk()

    answers = await asyncio.gather(
        asking.confirm(runner, "Eva"), asking.confirm(runner, "Adam"), return_exceptions=True
    )

    assert sorted(isinstance(answer, NotNowError) for answer in answers) == [False, True]
    assert await PatientOperator().attend(runner, running) is SessionState.FINISHED
