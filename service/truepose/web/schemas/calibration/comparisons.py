"""How the causes on one robot change over time."""

from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from truepose.analysis.comparison import dated
from truepose.diagnosis.alarms import Alarm, Appeared, alarms
from truepose.diagnosis.history import CauseOverTime, Change, Sighting
from truepose.domain.results.diagnosis import Confidence
from truepose.exchange.outgoing import Quantity
from truepose.storage.records import DiagnosisRecord
from truepose.web.schemas.base import RecordId, Reply
from truepose.web.schemas.calibration.diagnoses import (
    DiagnosisSummaryReply,
    MeasuredAt,
    diagnosis_summary_reply,
)
from truepose.words.catalogue import IN_ENGLISH


class SignReply(Reply):
    """What one diagnosis says of a cause; numbers are null where it did not find it."""

    diagnosis_id: RecordId
    measured_at: MeasuredAt
    sighting: Sighting = Field(
        description="`not_visible`: these readings could not show it; `part_of_start`: the model had it."
    )
    amplitude: Quantity = Field(examples=[0.021])
    amplitude_standard_uncertainty: Quantity = Field(examples=[0.003])
    confidence: Confidence | None


class ChangeReply(Reply):
    """How far an amplitude changed between two diagnoses that found it, in its unit."""

    from_diagnosis_id: RecordId
    to_diagnosis_id: RecordId
    difference: Quantity = Field(description="Later less earlier.", examples=[0.012])
    standard_uncertainty: Quantity = Field(examples=[0.004])
    p_value: float | None = Field(description="Corrected for all changes of the reply; null: not tested.")
    significant: bool = Field(description="The change is more than noise explains (level 5 % in all).")
    sentence: str


class VariantReply(Reply):
    """Which of several ways a cause acts in."""

    name: str = Field(description="`order` of a wave, `source joint` of a coupling.", examples=["order"])
    value: float = Field(examples=[2.0])


class CauseReply(Reply):
    """A cause in all diagnoses, oldest readings first."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    variant: VariantReply | None = Field(description="Null where there is but one way.")
    unit: str = Field(examples=["deg"])
    signs: list[SignReply]
    changes: list[ChangeReply] = Field(description="Between consecutive diagnoses that found it.")
    overall: ChangeReply | None = Field(description="From the first to the last, where there are more.")


class AlarmReply(Reply):
    """A cause that is larger than before, beyond chance."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    kind: Literal["grown", "appeared"]
    sentence: str


class ComparisonReply(Reply):
    """How the causes on one robot changed over time."""

    robot: str = Field(examples=["ABB IRB 120"])
    diagnoses: list[DiagnosisSummaryReply] = Field(
        description="What was compared, oldest readings first, undated ones last; of those of the same "
        "readings the latest."
    )
    undated_ids: list[int] = Field(
        description="Diagnoses of which nobody said when their readings were taken: last of the list, and "
        "nothing is subtracted from them."
    )
    causes: list[CauseReply]
    alarms: list[AlarmReply] = Field(description="What a service visit looks at first; empty: nothing grew.")


def comparison_reply(
    robot: str, records: Sequence[DiagnosisRecord], causes: Sequence[CauseOverTime]
) -> ComparisonReply:
    """Return a comparison as it travels."""
    return ComparisonReply(
        robot=robot,
        diagnoses=[diagnosis_summary_reply(record) for record in records],
        undated_ids=[record.id for record in records if record.measured_at is None],
        causes=[_cause(cause) for cause in causes],
        alarms=[_alarm(alarm) for alarm in alarms(causes, dated(records))],
    )


def _alarm(alarm: Alarm) -> AlarmReply:
    from truepose.reports.over_time.sentences import alarm_words

    return AlarmReply(
        effect=alarm.cause.effect,
        subject=alarm.cause.subject,
        kind="appeared" if isinstance(alarm, Appeared) else "grown",
        sentence=alarm_words(alarm, IN_ENGLISH),
    )


def _cause(cause: CauseOverTime) -> CauseReply:
    return CauseReply.of(
        cause,
        signs=[SignReply.of(s, amplitude_standard_uncertainty=s.standard_uncertainty) for s in cause.signs],
        changes=[_change(change) for change in cause.changes],
        overall=None if cause.overall is None else _change(cause.overall),
    )


def _change(change: Change) -> ChangeReply:
    return ChangeReply.of(change, from_diagnosis_id=change.from_id, to_diagnosis_id=change.to_id)
