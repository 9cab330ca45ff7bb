"""What a person wants otherwise of a session under way: a reading left out, or once more. Pure.

Nothing is deleted. A configuration that is left out has a line with the reason, and its readings count no
more; one that is wanted again comes after all others, once a person has confirmed that the arm may go
there: whoever asks for it looks at a table, not at the cell.
"""

from dataclasses import dataclass
from typing import Final

from truepose.domain.ledger import EntryKind
from truepose.domain.session import SessionPlan, config_of
from truepose.messages.message import Message, message
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import NotNowError, ReasonMissingError
from truepose.sessions.tracker.state import TrackerRecord
from truepose.sessions.tracker.steps import Step, StepKind

REVISIONS: Final = frozenset({CommandName.SKIP, CommandName.RETRY, CommandName.BACK})
_AGAIN: Final = {
    StepKind.WARM: message("session.revised.warm"),
    StepKind.REGISTER: message("session.revised.register"),
    StepKind.LOOK: message("session.revised.look"),
}


@dataclass(frozen=True, slots=True)
class Revision:
    """A line that is put on record, and what the person is told."""

    kind: EntryKind
    step_id: str
    text: str  # in the words of the person
    sentence: Message


def revision(
    act: OperatorCommand, plan: SessionPlan, record: TrackerRecord, present: Step | None
) -> Revision:
    """Return what an act of `REVISIONS` puts on record; raises NotNowError, ReasonMissingError."""
    match act.name:
        case CommandName.SKIP:
            return _skip(act, plan, record, present)
        case CommandName.RETRY:
            return _again(act.step_id or newest_stop(record), act, plan, record)
        case _:
            return _again(record.ended[-1] if record.ended else None, act, plan, record)


def can_be_skipped(present: Step | None) -> bool:
    """Whether the session can do without the present step."""
    return present is not None and present.kind in {StepKind.WARM, StepKind.MEASURE}


def newest_stop(record: TrackerRecord) -> str | None:
    """Return the step of the configuration that ended last; None before the first."""
    return next((step_id for step_id in reversed(record.ended) if config_of(step_id) is not None), None)


def _skip(act: OperatorCommand, plan: SessionPlan, record: TrackerRecord, present: Step | None) -> Revision:
    step_id = act.step_id or ("" if present is None else present.id)
    config = config_of(step_id)
    known = any(stop.config == config for stop in plan.stops)
    warms = present is not None and present.kind is StepKind.WARM and step_id == present.id
    if not (known or warms) or config in record.left_out:
        raise NotNowError(message("session.refused.cannot_leave_out"))
    reason = act.reason.strip()
    if not reason:
        raise ReasonMissingError(message("session.refused.leave_out_reason"))
    left_out = message("session.revised.left_out", config=config or 0)
    sentence = message("session.revised.warm_ends") if warms else left_out
    return Revision(EntryKind.SKIPPED, step_id, reason, sentence)


def _again(step_id: str | None, act: OperatorCommand, plan: SessionPlan, record: TrackerRecord) -> Revision:
    if step_id is None or (step_id not in record.ended and config_of(step_id) not in record.left_out):
        raise NotNowError(message("session.refused.nothing_to_repeat"))
    config = config_of(step_id)
    if config is None:
        kind = StepKind(step_id)
        if kind not in _AGAIN:
            raise NotNowError(message("session.refused.instruments_by_themselves"))
        return Revision(EntryKind.REOPENED, step_id, act.reason.strip(), _AGAIN[kind])
    # The order of a test of ISO 9283 is part of it, so nothing of it comes again (decision 0059).
    if any(stop.config == config and stop.group is not None for stop in plan.stops):
        raise NotNowError(message("session.refused.order_is_the_test"))
    sentence = message("session.revised.again", config=config)
    return Revision(EntryKind.REOPENED, step_id, act.reason.strip(), sentence)
