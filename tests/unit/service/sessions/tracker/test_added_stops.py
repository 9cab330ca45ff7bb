"""Configurations added to a session under way: kept first, measured last, after a person has confirmed."""

import asyncio
import math
from dataclasses import replace

import pytest

from tests.helpers.domain import asking
from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.tracker.fakes import make_plan, make_stop
from tests.unit.service.sessions.tracker.operators import PatientOperator, until
from truepose.domain.session import SessionState
from truepose.sessions.errors import NotNowError, PlanRefusedError
from truepose.sessions.tracker.runner import TrackerRunner

ADDED = (make_stop(11), make_stop(12))
MOVES_PER_STOP = 2  # the approach and the stop itself


class Shelf:
    """Keeps what was added, or cannot."""

    def __init__(self, error=None):
        self.kept = 0
        self._error = error

    async def __call__(self):
        if self._error is not None:
            raise self._error
        self.kept += 1


class Session:
    """A session on a fake cell, with an operator who confirms what is asked."""

    def __init__(self, cell):
        self.cell = cell
        self.operator = PatientOperator()
        self.runner = TrackerRunner(make_plan(2), cell.cell, cell.journal)
        self.running = asyncio.create_task(self.runner.run())

    async def attended(self):
        async with asyncio.timeout(HANGS_S):
            return await self.operator.attend(self.runner, self.running)

    def measured(self):
        return [point.config for point in self.cell.journal.points]


@pytest.fixture
async def session(cell):
    return Session(cell)


async def test_added_configurations_are_measured_after_the_others(session):
    shelf = Shelf()
    await session.runner.add_stops(ADDED, shelf)

    ended = await session.attended()

    assert ended is SessionState.FINISHED
    assert session.measured() == [1, 2, 11, 12]
    assert shelf.kept == 1
    assert (session.runner.progress.planned, session.runner.progress.done) == (4, 4)


async def test_the_fixed_nests_are_looked_at_once_more_after_them(session):
    await session.runner.add_stops(ADDED, Shelf())

    await session.attended()

    last_point = session.cell.journal.points[-1].time_s
    looks = [reading for reading in session.cell.journal.fixed if reading.time_s > last_point]
    assert {look.fixed_nest for look in looks} == {1, 2, 3}


async def test_the_robot_does_not_go_there_before_a_person_has_confirmed(session):
    moves_when_asked = []
    session.operator.before_answer = lambda _: moves_when_asked.append(len(session.cell.robot.moves))
    await session.runner.add_stops(ADDED, Shelf())

    await session.attended()

    assert moves_when_asked == [0, 2 * MOVES_PER_STOP]
    assert "were added to the plan" in session.operator.questions[1]
    assert "Is the cell clear" in session.operator.questions[1]


async def test_what_is_added_while_the_question_is_open_is_asked_for_again(session):
    late = (make_stop(13),)
    adding = []

    def before_answer(question):
        if "were added" in question and not adding:
            adding.append(asyncio.create_task(session.runner.add_stops(late, Shelf())))

    session.operator.before_answer = before_answer
    await session.runner.add_stops(ADDED, Shelf())

    await session.attended()

    assert session.measured() == [1, 2, 11, 12, 13]
    assert len([question for question in session.operator.questions if "were added" in question]) == 2


async def test_a_paused_session_takes_more_and_asks_when_it_comes_to_them(session):
    session.cell.robot.before_move = pause_once(session)

    await session.attended()

    assert session.measured() == [1, 2, 11, 12]
    assert ["Paused on request" in q for q in session.operator.questions] == [False, True, False]


def pause_once(session):
    async def before_move():
        session.cell.robot.before_move = None
        await asking.pause(session.runner, "Ada")
        await session.runner.add_stops(ADDED, Shelf())

    return before_move


@pytest.mark.parametrize("ending", ["finished", "aborted"])
async def test_a_session_that_has_ended_takes_no_more(ending, session):
    shelf = Shelf()
    if ending == "aborted":
        await until(lambda: session.runner.prompt is not None)
        await asking.end(session.runner, "Ada")
    await session.attended()

    with pytest.raises(NotNowError, match=f"The session is {ending}; plan a new session"):
        await session.runner.add_stops(ADDED, shelf)

    assert shelf.kept == 0


async def test_nothing_is_added_while_the_session_ends(session):
    refusals = []

    async def before_move():
        session.cell.robot.before_move = None
        await asking.end(session.runner, "Ada")
        with pytest.raises(NotNowError) as refusal:
            await session.runner.add_stops(ADDED, Shelf())
        refusals.append(str(refusal.value))

    session.cell.robot.before_move = before_move

    await session.attended()

    assert refusals == ["The session is aborting; plan a new session for the remaining configurations."]
    assert session.runner.progress.planned == 2


@pytest.mark.parametrize(
    ("stop", "words"),
    [
        (make_stop(1), "is in the plan twice"),
        (replace(make_stop(11), joints_rad=(math.radians(200.0), *make_stop(11).joints_rad[1:])), "joint 1"),
        (make_stop(11, nest=9), "9"),
    ],
)
async def test_what_the_cell_cannot_do_is_refused_and_not_kept(stop, words, session):
    shelf = Shelf()
    with pytest.raises(PlanRefusedError, match=words):
        await session.runner.add_stops((stop,), shelf)

    assert shelf.kept == 0
    assert await session.attended() is SessionState.FINISHED
    assert session.measured() == [1, 2]


async def test_what_could_not_be_kept_is_not_measured(session):
    with pytest.raises(OSError, match="no space"):
        await session.runner.add_stops(ADDED, Shelf(OSError("no space left on the disk")))

    await session.attended()
    assert session.measured() == [1, 2]


async def test_a_session_does_not_finish_while_more_is_being_kept(session):
    gate = asyncio.Event()

    async def slow():
        await gate.wait()

    adding = asyncio.create_task(session.runner.add_stops(ADDED, slow))
    await asyncio.sleep(0)
    attending = asyncio.create_task(session.attended())
    for _ in range(200):
        await asyncio.sleep(0)
    gate.set()
    await adding

    assert await attending is SessionState.FINISHED
    assert session.measured() == [1, 2, 11, 12]
