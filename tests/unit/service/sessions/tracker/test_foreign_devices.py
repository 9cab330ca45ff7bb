"""A tracker or a robot that is exchanged under a session: nothing is measured and nothing moves unasked."""

import asyncio
from dataclasses import replace

import pytest

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from tests.unit.service.sessions.tracker.fakes import make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, begun, run_session, until
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.ledger import Expected
from truepose.sessions.errors import NotNowError
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.errors import ConnectionLostError

A, B = "390001", "777777"


class Accepting(PatientOperator):
    """Names the foreign tracker when it is asked about one; does `mend` before any other answer."""

    def __init__(self, serial: str = "", patience: int = 6) -> None:
        super().__init__(patience)
        self._serial = serial

    async def _answer(self, runner: TrackerRunner) -> None:
        asked = english(question(runner))
        if self._serial and f"accept {self._serial}" in asked:
            self.questions.append(asked)
            await asking.confirm(runner, "Eva", self._serial)
        else:
            await super()._answer(runner)


def expecting(cell, **serials):
    cell.cell = replace(cell.cell, expected=Expected(serials))


def at_reading(cell, n_before, do):
    """Do something once, when a tool nest has just been measured after so many: before it is stored."""
    measure, done = cell.tracker.measure_point, []

    async def measured(**how):
        reading = await measure(**how)
        if cell.robot.moves and cell.tracker.on_the_arm and len(cell.journal.points) == n_before and not done:
            done.append(n_before)
            do()
        return reading

    cell.tracker.measure_point = measured


def exchanged(cell, serial=B):
    def do():
        cell.tracker.serial = serial

    return do


def lost(cell):
    def do():
        cell.tracker.connected = False
        raise ConnectionLostError("the cable was pulled")

    return do


def serials(cell):
    return [point.instrument_serial for point in cell.journal.points]


def findings(cell):
    return [(taken.device, taken.finding, taken.serial, taken.person) for taken in cell.journal.identities]


async def test_what_was_met_first_is_on_record_and_every_reading_says_whose_it_is(cell):
    await run_session(cell, make_plan(2))

    assert findings(cell) == [("tracker", "first", A, None), ("robot", "first", "120-1", None)]
    assert serials(cell) == [A, A]
    assert {nest.instrument_serial for nest in cell.journal.fixed} == {A}
    assert cell.journal.registrations[0].instrument_serial == A


async def test_a_tracker_that_the_cell_file_does_not_name_measures_nothing_unasked(cell):
    expecting(cell, tracker="390003")

    ended = await run_session(cell, make_plan(2))  # a patient operator confirms, and never names the tracker

    assert ended is SessionState.ABORTED
    assert cell.tracker.measurements == 0
    assert cell.robot.moves == []
    assert [f for f in findings(cell) if f[1] == "accepted"] == []


async def test_a_named_person_accepts_it_by_its_serial_number(cell):
    expecting(cell, tracker="390003")
    operator = Accepting(A)

    ended = await run_session(cell, make_plan(2), operator)

    assert ended is SessionState.FINISHED
    assert ("tracker", "accepted", A, "Eva") in findings(cell)
    assert sum("390003" in question for question in operator.questions) == 1
    assert any("Eva accepted tracker" in note for note in cell.journal.notes)


async def test_a_tracker_exchanged_between_reading_and_record_stores_nothing_of_it(cell):
    at_reading(cell, 1, exchanged(cell))

    await run_session(cell, make_plan(3))

    assert [(point.config, point.instrument_serial) for point in cell.journal.points] == [(1, A)]


async def test_an_accepted_one_is_placed_in_the_world_anew_before_it_measures(cell):
    at_reading(cell, 1, exchanged(cell))

    ended = await run_session(cell, make_plan(3), Accepting(B))

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 2, 3]
    assert serials(cell) == [A, B, B]
    assert [found.instrument_serial for found in cell.journal.registrations] == [A, B]


async def test_an_exchange_while_the_link_was_down_is_questioned_at_the_reconnection(cell):
    at_reading(cell, 1, lost(cell))
    operator = Accepting(B)
    operator.before_answer = lambda question: "cable" in question and exchanged(cell)()

    ended = await run_session(cell, make_plan(3), operator)

    assert ended is SessionState.FINISHED
    assert serials(cell) == [A, B, B]
    assert any(B in question for question in operator.questions)


async def test_one_that_is_put_back_goes_on_without_being_accepted(cell):
    at_reading(cell, 1, exchanged(cell))
    operator = PatientOperator(6)
    operator.before_answer = lambda question: B in question and exchanged(cell, A)()

    ended = await run_session(cell, make_plan(3), operator)

    assert ended is SessionState.FINISHED
    assert serials(cell) == [A, A, A]
    assert len(cell.journal.registrations) == 2  # it was moved
    assert [f[1] for f in findings(cell)] == ["first", "first", "foreign", "same"]


async def test_swapped_and_swapped_back_is_asked_both_times(cell):
    at_reading(cell, 1, exchanged(cell))

    async def swap_back(entry):
        if entry.point is not None and entry.point.config == 2:
            exchanged(cell, A)()

    cell.journal.before = swap_back

    class Both(Accepting):
        async def _answer(self, runner):
            self._serial = B if f"accept {B}" in english(question(runner)) else A
            await super()._answer(runner)

    ended = await run_session(cell, make_plan(4), Both())

    assert ended is SessionState.FINISHED
    assert serials(cell) == [A, B, A, A]
    assert [f[2] for f in findings(cell) if f[1] == "accepted"] == [B, A]
    assert len(cell.journal.registrations) == 3


async def test_a_confirmation_meant_for_the_question_before_accepts_nothing(cell):
    expecting(cell, tracker="390003")
    runner, running = await begun(cell, make_plan(1))
    await asking.confirm(runner, "Eva")
    await until(lambda: "390003" in english(question(runner)) and runner.state.value.startswith("awaiting"))

    await asking.confirm(runner, "Eva")  # the tap again
    await until(lambda: len(cell.journal.states) >= 5 and runner.prompt is not None)

    assert "390003" in english(question(runner))
    assert cell.tracker.measurements == 0
    with pytest.raises(NotNowError, match="nothing was accepted"):
        await asking.confirm(runner, "Eva", "123")
    await asking.end(runner, "Eva")
    assert await running is SessionState.ABORTED


async def interrupted_at_the_question(cell):
    """Run a session until it questions a tracker, then kill it; returns what is on disk."""
    at_reading(cell, 1, exchanged(cell))
    runner, running = await begun(cell, make_plan(3))
    await asking.confirm(runner, "Eva")
    await until(lambda: B in english(question(runner)) and runner.state is SessionState.AWAITING_CONFIRMATION)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    return on_disk(cell)


def on_disk(cell):
    return tuple(cell.journal.entries)


async def test_a_restart_between_question_and_answer_puts_the_question_again(cell):
    history = await interrupted_at_the_question(cell)
    operator = Accepting(B)

    ended = await run_session(cell, make_plan(3), operator, history)

    assert ended is SessionState.FINISHED
    assert B in operator.questions[0]
    assert serials(cell) == [A, B, B]
    assert [found.instrument_serial for found in cell.journal.registrations] == [A, B]


async def test_a_restart_between_question_and_answer_accepts_nothing_by_itself(cell):
    history = await interrupted_at_the_question(cell)

    await run_session(cell, make_plan(3), PatientOperator(), history)

    assert serials(cell) == [A]


async def test_an_acceptance_survives_a_restart_and_the_registration_of_the_other_one_does_not(cell):
    history = await interrupted_at_the_question(cell)
    accepting = replace(cell.journal.identities[-1], finding="accepted", person="Eva")
    accepted = LedgerEntry("", EntryKind.NOTED, cell.clock.time_s, identity=accepting)

    ended = await run_session(cell, make_plan(3), PatientOperator(1), (*history, accepted))

    assert ended is SessionState.FINISHED
    assert serials(cell) == [A, B, B]
    assert [found.instrument_serial for found in cell.journal.registrations] == [A, B]


async def test_another_robot_is_refused_however_often_somebody_confirms(cell):
    expecting(cell, robot="120-9")

    ended = await run_session(cell, make_plan(2), Accepting("120-1"))

    assert ended is SessionState.ABORTED
    assert cell.robot.moves == []


async def test_a_robot_that_is_exchanged_without_a_lost_link_does_not_move(cell):
    def exchange():
        cell.robot.serial = "120-2"

    at_reading(cell, 0, exchange)
    operator = PatientOperator(4)

    ended = await run_session(cell, make_plan(3), operator)

    assert ended is SessionState.ABORTED
    assert len(cell.robot.moves) == 2  # to the first configuration
    assert any("120-2" in question for question in operator.questions)


async def test_the_right_robot_put_back_goes_on_and_skips_nothing(cell):
    def exchange():
        cell.robot.serial = "120-2"

    def put_back(question):
        if "A different robot" in question and len(operator.questions) > 3:
            cell.robot.serial = "120-1"

    at_reading(cell, 0, exchange)
    operator = PatientOperator(8)
    operator.before_answer = put_back

    ended = await run_session(cell, make_plan(3), operator)

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 2, 3]


async def test_devices_that_tell_no_number_are_never_questioned(cell):
    cell.tracker.serial = cell.robot.serial = "unknown"
    expecting(cell, tracker=A, robot="120-1")
    operator = PatientOperator()

    ended = await run_session(cell, make_plan(2), operator)

    assert ended is SessionState.FINISHED
    assert len(operator.questions) == 1
    assert cell.journal.identities == []
    assert serials(cell) == ["", ""]


async def test_a_tracker_that_falls_silent_is_noted_and_measures_on(cell):
    at_reading(cell, 0, exchanged(cell, "unknown"))

    ended = await run_session(cell, make_plan(2))

    assert ended is SessionState.FINISHED
    assert sum("no longer reports its serial number" in note for note in cell.journal.notes) == 1
    assert serials(cell) == ["", ""]
