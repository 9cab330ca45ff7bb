"""What a person wants otherwise of a session under way: a reading left out, or once more. Pure.

Nothing is deleted. A configuration that is left out has a line with the reason, and its readings count no
more; one that is wanted again comes after all others, once a person has confirmed that the arm may go
there: whoever asks for it looks at a table, not at the cell.
"""

from dataclasses import dataclass
from typing import Final

from truepose.domain.measurement.ledger import EntryKind
from truepose.domain.measurement.session import SessionPlan, config_of
from truepose.sequencing.engine.acts import Act, ActName
from truepose.sequencing.errors import NotNowError, ReasonMissingError
from truepose.sequencing.tracker.plan.steps import Step, StepKind
from truepose.sequencing.tracker.state_so_far import TrackerRecord

REVISIONS: Final = frozenset({ActName.SKIP, ActName.RETRY, ActName.BACK})
_AGAIN: Final = {
    StepKind.WARM: "The warm-up begins anew; the tracker is placed in the world after it.",
    StepKind.REGISTER: "The tracker is placed in the world anew.",
    StepKind.LOOK: "The fixed nests are looked at once more.",
}


@dataclass(frozen=True, slots=True)
class Revision:
    """A line that is put on record, and what the person is told."""

    kind: EntryKind
    step_id: str
    text: str
    sentence: str


def revision(act: Act, plan: SessionPlan, record: TrackerRecord, present: Step | None) -> Revision:
    """Return what an act of `REVISIONS` puts on record; raises NotNowError, ReasonMissingError."""
    match act.name:
        case ActName.SKIP:
            return _skip(act, plan, record, present)
        case ActName.RETRY:
            return _again(act.step_id or newest_stop(record), act, plan, record)
        case _:
            return _again(record.ended[-1] if record.ended else None, act, plan, record)


def can_be_skipped(present: Step | None) -> bool:
    """Whether the session can do without the present step."""
    return present is not None and present.kind in {StepKind.WARM, StepKind.MEASURE}


def newest_stop(record: TrackerRecord) -> str | None:
    """Return the step of the configuration that ended last; None before the first."""
    return next((step_id for step_id in reversed(record.ended) if config_of(step_id) is not None), None)


def _skip(act: Act, plan: SessionPlan, record: TrackerRecord, present: Step | None) -> Revision:
    step_id = act.step_id or ("" if present is None else present.id)
    config = config_of(step_id)
    known = any(stop.config == config for stop in plan.stops)
    warms = present is not None and present.kind is StepKind.WARM and step_id == present.id
    if not (known or warms) or config in record.left_out:
        raise NotNowError("That step cannot be left out; the readings would have no place in the world.")
    reason = act.reason.strip()
    if not reason:
        raise ReasonMissingError("A configuration is left out for a reason: say it.")
    sentence = "The warm-up ends here." if warms else f"Configuration {config} is left out."
    return Revision(EntryKind.SKIPPED, step_id, reason, sentence)


def _again(step_id: str | None, act: Act, plan: SessionPlan, record: TrackerRecord) -> Revision:
    if step_id is None or (step_id not in record.ended and config_of(step_id) not in record.left_out):
        raise NotNowError("Nothing of that kind has been done yet; there is nothing to do again.")
    config = config_of(step_id)
    if config is None:
        kind = StepKind(step_id)
        if kind not in _AGAIN:
            raise NotNowError("The instruments are made ready whenever that is needed.")
        return Revision(EntryKind.REOPENED, step_id, act.reason.strip(), _AGAIN[kind])
    if any(stop.config == config and stop.group is not None for stop in plan.stops):
        raise NotNowError("The order of these configurations is part of the test; none comes again.")
    sentence = f"Configuration {config} is measured again, after the others and once a person has confirmed."
    return Revision(EntryKind.REOPENED, step_id, act.reason.strip(), sentence)
