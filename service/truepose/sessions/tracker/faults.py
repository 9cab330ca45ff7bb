"""What a fault means to a tracker session: the lines that follow from it. Pure.

- A configuration whose reading fails is skipped with the reason, unless nothing has been measured since a
  person last had the session go on, or several in a row have failed: then the instrument is suspect, and
  the session pauses.
- A configuration to which the robot refuses to go is skipped, and a person confirms before the next motion.
- Before a way that is none of the plan's, and on which something would touch, a person confirms.
- A lost link and a robot that is not where it was left are the same thing to a session: nothing moves before
  a person confirms; then the devices are opened anew, the fixed nests are looked at, and the step that was
  interrupted begins again.
- Another tracker than the expected one measures nothing before a person has accepted it by its serial
  number; then it is placed in the world anew. Another robot is refused.
"""

from collections.abc import Iterator
from typing import Final

from truepose.domain.errors import text_of
from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionPlan, SessionState
from truepose.messages.message import Message, Text, as_sentence, message, together
from truepose.sessions.engine.runner import is_interruption
from truepose.sessions.engine.unattended import Line, awaits_person
from truepose.sessions.errors import (
    AttentionNeededError,
    ForeignInstrumentError,
    MotionForbiddenError,
    ReadingRejectedError,
    SessionError,
    WayNotClearError,
)
from truepose.sessions.tracker.state import TrackerSituation
from truepose.sessions.tracker.steps import Step, StepKind
from truepose_drivers.errors import (
    ConfigurationError,
    DeviceRefusedError,
    DriverError,
    MeasurementFailedError,
)

_INTERRUPTIONS_PER_STOP: Final = 2  # a configuration on which the link breaks so often is left out


def lines_after(
    error: SessionError | DriverError,
    step: Step,
    now: TrackerSituation,
    plan: SessionPlan,
    *,
    moving: bool = False,
) -> Iterator[Line]:
    """Yield what is put on record after a fault within a step; raises what is no fault of a cell.

    `moving`: the arm had been sent somewhere, and was not known to have arrived.
    """
    reason = text_of(error)
    if isinstance(error, WayNotClearError):
        return iter((awaits_person(reason),))
    # Then: among what it covers are errors that the cases below would take for a failed reading.
    if is_interruption(error) or isinstance(error, MotionForbiddenError):
        return _after_interruption(reason, step, now)
    match error:
        case DeviceRefusedError() if moving:
            return _after_refused_motion(reason, step)
        case MeasurementFailedError() | DeviceRefusedError() | ReadingRejectedError():
            return _after_failed_measurement(reason, step, now, plan)
        case AttentionNeededError():
            return _after_contradiction(reason, now)
        case ForeignInstrumentError():
            return _after_exchange(reason, now)
        case ConfigurationError():
            return iter((Line(EntryKind.CONTROL, text=reason, entered=SessionState.FAILED),))
        case _:
            raise error


def _after_interruption(reason: Text, step: Step, now: TrackerSituation) -> Iterator[Line]:
    yield Line(EntryKind.REOPENED, StepKind.OPEN)
    # Otherwise a configuration in which a cable comes loose would have a person confirm for ever.
    if step.stop is not None and now.interruptions + 1 >= _INTERRUPTIONS_PER_STOP:
        yield Line(EntryKind.SKIPPED, step.id, message("session.interrupted_twice", why=reason))
    yield awaits_person(together(as_sentence(reason), message("session.put_right")), step.id)


def _after_refused_motion(reason: Text, step: Step) -> Iterator[Line]:
    yield Line(EntryKind.SKIPPED, step.id, reason)
    # The arm is not where the way to the next stop begins, so that nobody has looked at the way from here.
    yield awaits_person(as_sentence(reason), step.id)


def _after_failed_measurement(
    reason: Text, step: Step, now: TrackerSituation, plan: SessionPlan
) -> Iterator[Line]:
    if step.stop is None:
        yield _paused(message("session.while", doing=step.title, why=reason))
        return
    suspect = not now.measured_lately or now.failures + 1 >= plan.failures_in_a_row
    # A step pauses the session once. A person has looked by then, so that it is left out when it fails again.
    if not suspect or now.paused_before:
        yield Line(EntryKind.SKIPPED, step.id, reason)
        return
    yield _paused(
        message(
            "session.not_measured",
            config=step.stop.config,
            sentence=as_sentence(reason),
            suspect=_why_suspect(now),
        ),
        step.id,
    )


def _why_suspect(now: TrackerSituation) -> Message:
    if not now.measured_lately:
        return message("session.suspect.nothing")
    return message("session.suspect.row", number=now.failures + 1)


def _after_contradiction(reason: Text, now: TrackerSituation) -> Iterator[Line]:
    # Where there is none nothing has been contradicted.
    if now.registration is not None:
        yield Line(EntryKind.REOPENED, StepKind.REGISTER)
    yield _paused(reason)


def _after_exchange(question: Text, now: TrackerSituation) -> Iterator[Line]:
    yield Line(EntryKind.REOPENED, StepKind.OPEN)
    if now.last_known is not None:  # also of one that is put back: it was moved
        yield Line(EntryKind.REOPENED, StepKind.REGISTER)
    yield awaits_person(question)


def _paused(reason: Text, step_id: str = "") -> Line:
    return Line(EntryKind.CONTROL, step_id, reason, SessionState.PAUSED)
