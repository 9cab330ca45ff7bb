"""A session whose records are refused stops between two motions, loses nothing and goes on when it can."""

import asyncio
import contextlib
from dataclasses import replace

import pytest

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.tracker.fakes import FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import until
from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.errors import NotNowError
from truepose.sessions.tracker.runner import TrackerRunner


def states(cell):
    return [state for state, _, _ in cell.journal.states]


class Run:
    """A session of three configurations that runs until the disk is full at a motion of choice."""

    def __init__(self, full_at_motion=None):
        self.cell = FakeCell()
        self.runner = TrackerRunner(make_plan(3), self.cell.cell, self.cell.journal)
        self._full_at = full_at_motion
        self.cell.robot.before_move = self._fill

    async def _fill(self):
        if len(self.cell.robot.moves) == self._full_at:
            self.cell.journal.fill()

    async def __aenter__(self):
        self.task = asyncio.create_task(self.runner.run())
        await until(lambda: self.runner.state is SessionState.AWAITING_CONFIRMATION)
        return self

    async def __aexit__(self, *_):
        self.task.cancel()
        await asyncio.gather(self.task, return_exceptions=True)

    async def confirm(self):
        await until(lambda: self.runner.state is SessionState.AWAITING_CONFIRMATION)
        await asking.confirm(self.runner, "Eva")

    async def end(self):
        """Confirm whatever is asked until the session has ended."""
        while not self.task.done():
            if self.runner.state is SessionState.AWAITING_CONFIRMATION and self.runner.trouble is None:
                await asking.confirm(self.runner, "Eva")
            await asyncio.sleep(0)
        return self.task.result()


@contextlib.asynccontextmanager
async def on_full_disk():
    """A session that was confirmed, and whose disk is full since the motion to its first stop."""
    async with Run(full_at_motion=1) as run:  # the second motion
        await run.confirm()
        await asyncio.wait_for(run.cell.journal.refused.wait(), HANGS_S)
        await asyncio.sleep(0)
        yield run


async def test_a_reading_that_is_refused_is_kept_and_written_and_nothing_moves_meanwhile():
    async with on_full_disk() as run:  # the second motion is the one to the first stop
        moved, read = len(run.cell.robot.moves), run.cell.tracker.measurements

        assert "cannot be written (database or disk is full). Nothing moves." in english(run.runner.trouble)
        assert run.runner.state is states(run.cell)[-1] is SessionState.RUNNING
        run.cell.journal.make_room()
        await until(lambda: run.runner.state is SessionState.AWAITING_CONFIRMATION)

        assert [point.config for point in run.cell.journal.points] == [1]
        assert run.cell.tracker.measurements == read  # written, not measured again
        assert len(run.cell.robot.moves) == moved
        assert "could not be written for a while" in english(question(run.runner))
        assert english(question(run.runner)).endswith(english(CELL_CLEAR))
        assert run.runner.trouble is None
        assert await run.end() is SessionState.FINISHED
        assert [point.config for point in run.cell.journal.points] == [1, 2, 3]


async def test_an_end_that_cannot_be_recorded_takes_effect_and_is_recorded_later():
    async with on_full_disk() as run:
        moved = len(run.cell.robot.moves)

        said = await asking.end(run.runner, "Eva")
        assert "cannot be written" in english(said)
        run.cell.journal.make_room()

        assert await run.task is SessionState.ABORTED
        assert run.cell.journal.states[-2] == (SessionState.ABORTING, "An abort was requested.", "Eva")
        assert states(run.cell)[-1] is SessionState.ABORTED
        assert len(run.cell.journal.points) == 1
        assert len(run.cell.robot.moves) == moved


async def test_a_pause_that_cannot_be_recorded_takes_effect_and_can_be_resumed():
    async with on_full_disk() as run:
        assert "cannot be written" in english(await asking.pause(run.runner, "Eva"))
        run.cell.journal.make_room()
        await until(lambda: run.runner.state is SessionState.PAUSED)
        await asking.resume(run.runner, "Eva")

        assert await run.end() is SessionState.FINISHED
        assert states(run.cell)[-1] is SessionState.FINISHED


async def test_the_request_of_a_halt_that_holds_gets_the_same_answer_again():
    async with on_full_disk() as run:
        pause = OperatorCommand(CommandName.PAUSE, "Eva", key="tap-1")
        answers = [await run.runner.ask(replace(pause)) for _ in range(2)]
        for other in (replace(pause, key="tap-2"), replace(pause, name=CommandName.ABORT)):
            with pytest.raises(RecordRefusedError):
                await run.runner.ask(other)

        assert answers[0] == answers[1]
        assert "cannot be written" in english(answers[0].sentence)
        run.cell.journal.make_room()
        await until(lambda: run.runner.state is SessionState.PAUSED)
        assert states(run.cell).count(SessionState.PAUSED) == 1


async def test_an_end_that_is_refused_while_nothing_moves_was_not_asked_for():
    async with Run() as run:
        run.cell.journal.fill()
        with pytest.raises(RecordRefusedError):
            await asking.end(run.runner, "Eva")
        run.cell.journal.make_room()

        assert await run.end() is SessionState.FINISHED
        assert SessionState.ABORTED not in states(run.cell)


async def test_a_confirmation_that_cannot_be_recorded_moves_nothing():
    async with Run() as run:
        run.cell.journal.fill()
        with pytest.raises(RecordRefusedError):
            await asking.confirm(run.runner, "Eva")
        for _ in range(20):
            await asyncio.sleep(0)

        assert run.cell.robot.moves == []
        assert run.runner.state is states(run.cell)[-1] is SessionState.AWAITING_CONFIRMATION


async def test_every_record_of_a_session_may_be_refused_once():
    async with Run() as run:
        journal = run.cell.journal
        journal.before = refusing_first(journal)

        while not run.task.done():
            if run.runner.state is SessionState.AWAITING_CONFIRMATION and run.runner.trouble is None:
                with contextlib.suppress(RecordRefusedError):
                    await asking.confirm(run.runner, "Eva")
            journal.make_room()
            await asyncio.sleep(0)

        assert run.task.result() is SessionState.FINISHED
        assert sorted(point.config for point in journal.points) == [1, 2, 3]
        assert states(run.cell)[-1] is SessionState.FINISHED


# Not that a step begins: a person who has the session go on is asked again before its motion, for ever.
REFUSED_ONCE = {
    EntryKind.CONTROL,
    EntryKind.MEASURED,
    EntryKind.READ,
    EntryKind.SKIPPED,
    EntryKind.COMPUTED,
    EntryKind.NOTED,
}


def refusing_first(journal):
    """Return what refuses every line of these kinds once before it is taken."""
    refused = set()

    async def refuse(entry):
        if entry.kind in REFUSED_ONCE - refused:
            refused.add(entry.kind)
            journal.has_room.clear()
            raise RecordRefusedError("database is locked")
        refused.discard(entry.kind)

    return refuse


async def test_what_makes_no_sense_is_refused_also_while_the_disk_refuses():
    async with on_full_disk() as run:
        with pytest.raises(NotNowError):
            await asking.resume(run.runner, "Eva")
        with pytest.raises(NotNowError):
            await asking.confirm(run.runner, "Eva")
