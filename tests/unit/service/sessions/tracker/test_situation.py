"""What is due in a tracker session follows from its ledger, wherever that is cut."""

import pytest

from tests.unit.service.sessions.tracker.fakes import FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import SessionState, stop_id
from truepose.sessions.engine.runner import is_interruption
from truepose.sessions.errors import AttentionNeededError, MotionForbiddenError, PlanRefusedError
from truepose.sessions.tracker.faults import lines_after
from truepose.sessions.tracker.state import situation, steps
from truepose.sessions.tracker.steps import StepKind, visit
from truepose_drivers.errors import (
    BeamBrokenError,
    ConfigurationError,
    ConnectionLostError,
    NotInitialisedError,
)

PLAN = make_plan(4, reference_every=2, registration_readings=2, two_face_check=False)
FIXED_NESTS = 3
ALL = tuple(stop.config for stop in PLAN.stops)
FIRST = visit(PLAN, PLAN.stops[0])


def line(kind, step_id="", **said):
    return LedgerEntry(step_id, kind, 1.0, **said)


ASKED = line(EntryKind.CONTROL, entered=SessionState.AWAITING_CONFIRMATION, stops=ALL)
RUNS = line(EntryKind.CONTROL, entered=SessionState.RUNNING)
OPENED = line(EntryKind.ENDED, StepKind.OPEN)
REGISTERED = line(EntryKind.COMPUTED, StepKind.REGISTER)
LOOKED = line(EntryKind.ENDED, StepKind.LOOK)
READY = (ASKED, RUNS, OPENED, REGISTERED, LOOKED)


def measured(config):
    return line(EntryKind.MEASURED, stop_id(config))


def now(*lines):
    return situation(PLAN, FIXED_NESTS, lines)


def due(*lines):
    step = now(*lines).step
    return None if step is None else step.id


def test_the_listing_is_what_is_due_where_every_step_succeeds():
    kinds = [step.id for step in steps(PLAN, FIXED_NESTS)]

    assert kinds == [
        "instruments",
        "world-frame",
        "fixed-nests",
        "stop-1",
        "stop-2",
        "fixed-nests",
        "stop-3",
        "stop-4",
        "fixed-nests",
    ]


async def test_a_session_that_nothing_disturbs_begins_exactly_the_steps_that_were_listed(cell):
    await run_session(cell, PLAN)

    begun = [entry.step_id for entry in cell.journal.entries if entry.kind is EntryKind.BEGUN]
    assert begun == [step.id for step in steps(PLAN, FIXED_NESTS)]


def test_a_session_that_is_ready_goes_to_the_first_stop():
    assert due(*READY) == "stop-1"
    assert due(*READY, measured(1), measured(2)) == "fixed-nests"
    assert due(*READY, measured(1), measured(2), LOOKED) == "stop-3"


def test_nothing_is_due_once_every_stop_has_ended_and_the_fixed_nests_were_looked_at():
    ended = [measured(1), measured(2), LOOKED, measured(3), line(EntryKind.SKIPPED, stop_id(4))]

    assert due(*READY, *ended) == "fixed-nests"
    assert due(*READY, *ended, LOOKED) is None


def test_instruments_that_are_opened_anew_are_followed_by_a_look_at_the_fixed_nests():
    reopened = line(EntryKind.REOPENED, StepKind.OPEN)

    assert due(*READY, measured(1), reopened) == "instruments"
    assert due(*READY, measured(1), reopened, OPENED) == "fixed-nests"


def test_a_registration_that_was_given_up_is_found_anew():
    given_up = now(*READY, line(EntryKind.REOPENED, StepKind.REGISTER))

    assert given_up.step.kind is StepKind.REGISTER
    assert given_up.registration is None


def test_after_a_restart_everything_is_made_ready_again():
    restarted = line(
        EntryKind.CONTROL,
        entered=SessionState.AWAITING_CONFIRMATION,
        control=Control.RESTARTED,
        stops=ALL,
    )

    assert due(*READY, measured(1), restarted, RUNS) == "instruments"


def test_the_arm_may_go_only_where_a_person_was_asked_about():
    some = line(EntryKind.CONTROL, entered=SessionState.AWAITING_CONFIRMATION, stops=(1, 2))

    found = now(some, RUNS, OPENED, REGISTERED, LOOKED)

    assert [stop.config for stop in found.unasked] == [3, 4]
    assert now(some).unasked == PLAN.stops  # asked, and not answered yet
    assert now(*READY).unasked == ()


async def killed_after(n_lines):
    """Run a session with one skip and one lost link, cut its ledger, and take it up from there."""
    first = FakeCell()
    first.robot.faults = {3: ConnectionLostError("the cable was pulled")}
    await run_session(first, PLAN)
    kept = tuple(first.journal.entries[:n_lines])
    again = FakeCell()
    again.clock.time_s = first.clock.time_s
    ended = await run_session(again, PLAN, PatientOperator(), kept)
    before = [entry.point.config for entry in kept if entry.point is not None]
    return ended, before, [point.config for point in again.journal.points]


@pytest.mark.parametrize("n_lines", range(0, 49, 3))
async def test_a_session_that_is_killed_anywhere_measures_every_configuration_once(n_lines):
    ended, before, after = await killed_after(n_lines)

    assert ended is SessionState.FINISHED
    assert before + after == list(ALL)


def texts(error, *lines, step=FIRST):
    return [(kept.kind, kept.step_id) for kept in lines_after(error, step, now(*lines), PLAN)]


def test_a_lost_link_has_the_instruments_opened_anew_and_a_person_asked():
    lost = ConnectionLostError("the cable was pulled")

    assert texts(lost, *READY) == [(EntryKind.REOPENED, "instruments"), (EntryKind.CONTROL, "stop-1")]
    assert is_interruption(lost)
    assert is_interruption(NotInitialisedError("the tracker lost its reference"))
    assert not is_interruption(BeamBrokenError("the beam was interrupted"))
    assert not is_interruption(MotionForbiddenError("a question is open"))


def test_a_configuration_where_the_link_broke_twice_is_left_out_also_after_a_restart():
    broke = line(EntryKind.CONTROL, stop_id(1), entered=SessionState.AWAITING_CONFIRMATION, stops=ALL)

    kept = texts(ConnectionLostError("again"), *READY, broke, RUNS, OPENED, LOOKED)

    assert (EntryKind.SKIPPED, "stop-1") in kept


def test_the_first_reading_that_fails_pauses_and_a_later_one_is_skipped():
    broken = BeamBrokenError("the beam was interrupted")

    assert texts(broken, *READY) == [(EntryKind.CONTROL, "stop-1")]
    assert texts(broken, *READY, measured(4)) == [(EntryKind.SKIPPED, "stop-1")]


def test_a_contradiction_gives_up_only_a_registration_that_there_is():
    moved = AttentionNeededError("nest 1 moved")

    assert texts(moved, ASKED, RUNS, OPENED) == [(EntryKind.CONTROL, "")]


def test_a_cell_that_is_set_up_wrongly_ends_the_session():
    (kept,) = lines_after(ConfigurationError("no such port"), FIRST, now(*READY), PLAN)

    assert kept.entered is SessionState.FAILED


def test_what_is_no_fault_of_the_cell_is_not_taken_for_one():
    with pytest.raises(PlanRefusedError):
        lines_after(PlanRefusedError("no such nest"), FIRST, now(*READY), PLAN)
