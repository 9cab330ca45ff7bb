"""Leaving a reading out, and taking one again: nothing is deleted, and no arm moves by a tap on a table."""

import asyncio
from dataclasses import replace

import pytest

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from tests.unit.service.sessions.tracker.fakes import FakeCell, make_plan, make_stop
from tests.unit.service.sessions.tracker.operators import until
from truepose.domain.ledger import EntryKind
from truepose.domain.session import PlannedStop, SessionState
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import NotNowError, PersonMissingError, ReasonMissingError
from truepose.sessions.tracker.revisions import can_be_skipped, revision
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.sessions.tracker.state import TrackerRecord
from truepose.sessions.tracker.steps import Step, StepKind

PERSON = "Eva"


class Halted:
    """A session that was paused by a person once so many stops were measured."""

    def __init__(self, cell, plan, after):
        self.cell = cell
        self.runner = TrackerRunner(plan, cell.cell, cell.journal)
        self.running = asyncio.create_task(self.runner.run())
        self._after = after

    async def __aenter__(self):
        await until(lambda: self.runner.prompt is not None)
        self.cell.robot.before_move = self._pause
        await asking.confirm(self.runner, PERSON)
        await until(lambda: self.runner.state is SessionState.PAUSED)
        self.cell.robot.before_move = None
        return self

    async def __aexit__(self, *_):
        if not self.running.done():
            await asking.end(self.runner, PERSON)
            await self.running

    async def _pause(self):
        if len(self.cell.journal.points) == self._after and self.runner.state is SessionState.RUNNING:
            await self.runner.act(OperatorCommand(CommandName.PAUSE, PERSON))

    async def act(self, name, step_id=None, reason="", key="k"):
        return await self.runner.act(
            OperatorCommand(name, PERSON, key=f"{name}-{key}", step_id=step_id, reason=reason)
        )

    async def go_on(self):
        await asking.resume(self.runner, PERSON)

    async def to_the_question(self):
        await until(lambda: self.runner.state is SessionState.AWAITING_CONFIRMATION)
        return question(self.runner)

    async def to_the_end(self):
        return await asyncio.wait_for(self.running, 60)


def measured(cell):
    return [point.config for point in cell.journal.points]


async def test_a_configuration_that_is_left_out_is_not_gone_to(cell):
    async with Halted(cell, make_plan(4), after=1) as session:
        answer = await session.act(CommandName.SKIP, "stop-3", "in the way")
        await session.go_on()

        assert await session.to_the_end() is SessionState.FINISHED

    assert english(answer.sentence) == "Configuration 3 is skipped."
    assert measured(cell) == [1, 2, 4]
    assert make_stop(3).joints_rad not in cell.robot.moves
    assert [(one.config, one.reason) for one in cell.journal.skipped] == [(3, "in the way")]


class Eyes:
    """Look at ways of a cell that is narrow once a test says so."""

    narrow = False

    async def __call__(self, ways):
        return message("room.be_ready") if self.narrow else ""


async def test_past_a_configuration_that_is_left_out_the_arm_goes_where_the_way_was_looked_at(cell):
    async with Halted(cell, make_plan(4), after=1) as session:
        noted = len(cell.journal.notes)
        await session.act(CommandName.SKIP, "stop-3", "in the way")
        await session.go_on()
        await session.to_the_end()

    assert [note for note in cell.journal.notes[noted:] if "not part of the plan" in note] == [
        "The arm took a path that is not part of the plan; it was checked beforehand and is collision-free."
    ]


async def test_where_something_touches_on_the_way_past_it_a_person_is_asked_and_says_so_once():
    cell, eyes = FakeCell(), Eyes()
    cell.cell = replace(cell.cell, look_at_ways=eyes)
    async with Halted(cell, make_plan(4), after=1) as session:
        await session.act(CommandName.SKIP, "stop-3", "in the way")
        eyes.narrow = True
        await session.go_on()
        question = await session.to_the_question()
        moves = len(cell.robot.moves)

        assert measured(cell) == [1, 2]
        assert english(question).startswith("The next path is not part of the plan. Be ready")
        await asking.confirm(session.runner, PERSON)
        assert await session.to_the_end() is SessionState.FINISHED

    assert measured(cell) == [1, 2, 4]
    assert len(cell.robot.moves) == moves + 2
    assert cell.journal.skipped[1:] == []  # it costs no configuration


async def test_what_was_measured_can_be_left_out_too():
    async with Halted(FakeCell(), make_plan(4), after=2) as session:
        await session.act(CommandName.SKIP, "stop-1", "I touched the reflector")

        assert session.runner.record.measured == {2}
        assert session.runner.progress.done == 1
        assert session.runner.progress.skipped == 1


@pytest.mark.parametrize("name", [CommandName.RETRY, CommandName.BACK])
async def test_what_comes_again_comes_last_and_after_a_question(name, cell):
    async with Halted(cell, make_plan(4), after=2) as session:
        await session.act(name)  # what was measured last
        await session.go_on()
        question = await session.to_the_question()
        moves = len(cell.robot.moves)

        assert measured(cell) == [1, 2, 3, 4]
        assert english(question).startswith("Next, configuration 2 is measured again.")
        for _ in range(50):
            await asyncio.sleep(0)
        assert len(cell.robot.moves) == moves

        await asking.confirm(session.runner, PERSON)
        assert await session.to_the_end() is SessionState.FINISHED

    assert measured(cell) == [1, 2, 3, 4, 2]


async def test_back_may_be_pressed_again_and_again():
    async with Halted(FakeCell(), make_plan(4, reference_every=9), after=2) as session:
        for number in range(3):
            await session.act(CommandName.BACK, key=str(number))

        assert session.runner.record.measured == set()
        assert session.runner.situation.step.id == "fixed-nests"  # they come before the first stop


async def test_the_fixed_nests_are_looked_at_when_somebody_wants_it(cell):
    async with Halted(cell, make_plan(4, reference_every=9), after=2) as session:
        before = len(cell.journal.fixed)
        await session.act(CommandName.RETRY, "fixed-nests")
        await session.go_on()
        await session.to_the_end()

        looks = [entry.step_id for entry in cell.journal.entries if entry.kind is EntryKind.ENDED]
    assert looks.count("fixed-nests") == 3  # first, when it was wanted, last
    assert len(cell.journal.fixed) == before + 6


@pytest.mark.parametrize(
    ("name", "step_id", "reason", "refused"),
    [
        (CommandName.SKIP, "stop-3", "  ", ReasonMissingError),
        (CommandName.SKIP, "stop-99", "why not", NotNowError),
        (CommandName.SKIP, "world-frame", "why not", NotNowError),
        (CommandName.SKIP, "stop-third", "why not", NotNowError),
        (CommandName.RETRY, "stop-", "", NotNowError),
        (CommandName.RETRY, "stop-4", "", NotNowError),  # not measured yet
        (CommandName.RETRY, "instruments", "", NotNowError),
    ],
)
async def test_what_makes_no_sense_changes_nothing(name, step_id, reason, refused):
    async with Halted(FakeCell(), make_plan(4), after=1) as session:
        lines = len(session.cell.journal.entries)
        with pytest.raises(refused):
            await session.act(name, step_id, reason)

        assert len(session.cell.journal.entries) == lines


async def test_an_act_is_done_once_however_often_it_arrives():
    async with Halted(FakeCell(), make_plan(4), after=1) as session:
        first = await session.act(CommandName.SKIP, "stop-3", "in the way")
        again = await session.act(CommandName.SKIP, "stop-3", "in the way")

        assert first == again
        assert len(session.cell.journal.skipped) == 1


async def test_a_configuration_that_is_left_out_while_it_is_measured_has_no_reading_that_counts(cell):
    async with Halted(cell, make_plan(3), after=1) as session:

        async def leave_out():
            if not cell.journal.skipped:
                await session.act(CommandName.SKIP, "stop-2", "something is in the beam")

        cell.robot.before_move = leave_out
        await session.go_on()
        await session.to_the_end()

    assert measured(cell) == [1, 3]


async def test_the_order_of_a_test_is_kept():
    stops = tuple(PlannedStop(n, make_stop(n).joints_rad, 1, group=1) for n in (1, 2, 3))
    async with Halted(FakeCell(), make_plan(stops=stops), after=1) as session:
        with pytest.raises(NotNowError, match="part of the test"):
            await session.act(CommandName.RETRY, "stop-1")


async def test_nobody_does_it_without_a_name():
    async with Halted(FakeCell(), make_plan(4), after=1) as session:
        with pytest.raises(PersonMissingError):
            await session.runner.act(
                OperatorCommand(CommandName.SKIP, " ", key="k", step_id="stop-2", reason="so")
            )


async def test_after_a_stop_a_person_confirms_anew(cell):
    async with Halted(cell, make_plan(4), after=1) as session:
        await session.go_on()
        cell.robot.before_move = lambda: session.runner.act(OperatorCommand(CommandName.STOP, PERSON))
        question = await session.to_the_question()
        cell.robot.before_move = None

        assert english(question).startswith("Stop was pressed.")
        await asking.confirm(session.runner, PERSON)
        assert await session.to_the_end() is SessionState.FINISHED

    assert measured(cell) == [1, 2, 3, 4]


WARM, LOOK = Step(StepKind.WARM, ()), Step(StepKind.LOOK, ())
FIRST = Step(StepKind.MEASURE, (), make_plan(2).stops[0])


@pytest.mark.parametrize(("present", "possible"), [(WARM, True), (FIRST, True), (LOOK, False), (None, False)])
def test_a_session_can_do_without_warming_and_without_a_configuration(present, possible):
    assert can_be_skipped(present) is possible


def skipped(present, step_id=None, reason="enough", **known):
    act = OperatorCommand(CommandName.SKIP, PERSON, step_id=step_id, reason=reason)
    return revision(act, make_plan(2), TrackerRecord(**known), present)


@pytest.mark.parametrize(
    ("present", "step_id", "left_out", "key"),
    [
        (WARM, None, WARM.id, "warm_ends"),
        (WARM, WARM.id, WARM.id, "warm_ends"),
        (FIRST, None, FIRST.id, "left_out"),
        (WARM, FIRST.id, FIRST.id, "left_out"),
        (None, FIRST.id, FIRST.id, "left_out"),
    ],
)
def test_what_is_skipped_is_the_step_that_is_named_else_the_present_one(present, step_id, left_out, key):
    found = skipped(present, step_id)

    assert (found.kind, found.step_id, found.text) == (EntryKind.SKIPPED, left_out, "enough")
    assert found.sentence.key == f"session.revised.{key}"


@pytest.mark.parametrize(
    ("present", "step_id", "known"),
    [
        (None, None, {}),
        (LOOK, None, {}),
        (FIRST, WARM.id, {}),
        (FIRST, None, {"left_out": {FIRST.stop.config}}),
    ],
)
def test_nothing_else_can_be_skipped_and_nothing_without_a_reason(present, step_id, known):
    with pytest.raises(NotNowError):
        skipped(present, step_id, **known)
    with pytest.raises(ReasonMissingError):
        skipped(WARM, reason=" ")
