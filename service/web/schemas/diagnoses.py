"""Diagnoses: requests, records, the document of the command line, and how causes change over time."""

from collections.abc import Sequence
from datetime import date
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from service.diagnosis.comparison import CauseOverTime, Change, Sighting, Sign
from service.domain.diagnosis import Confidence, Finding, HeldOut, Verdict
from service.exchange.diagnosis_document import diagnosis_document
from service.storage.records import DiagnosisRecord
from service.web.schemas.base import Number, RecordedAt, RecordId, Reply, Request, example, known
from service.web.schemas.results import Document, EffectName, StatisticsDocument


def _day(value: object) -> object:
    # The strict mode of requests, meant for numbers, would take no text for a day.
    return date.fromisoformat(value) if isinstance(value, str) and len(value) == len("2026-03-03") else value


Day = Annotated[date, BeforeValidator(_day)]
StartEffects = Annotated[
    list[EffectName] | None,
    Field(
        min_length=1,
        max_length=32,
        description="Effects of the model that the diagnosis starts from; none of them is a finding. "
        "Null: base, tool as far as unknown, geometry and compliance.",
    ),
]
MeasuredAt = Annotated[
    str,
    Field(description="When the readings were taken: a day, or UTC in ISO 8601.", examples=["2026-03-03"]),
]


class CauseDocument(Document):
    """A cause by its name."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])


class DetailDocument(Document):
    """One more number of a finding, in the unit that it names."""

    name: str = Field(examples=["order"])
    value: float | None = Field(examples=[2.0])
    unit: str = Field(examples=["1"])
    standard_uncertainty: float | None = Field(examples=[0.0])


class GainDocument(Document):
    """What the finding takes off the held-out errors."""

    rms_before_mm: float | None = Field(examples=[0.061])
    rms_after_mm: float | None = Field(examples=[0.019])
    interval_95_mm: list[float | None] = Field(
        min_length=2, max_length=2, description="Of the difference, before less after."
    )


class CurveDocument(Document):
    """Residuals along one variable, with what was fitted to them; units stand beside."""

    variable: str = Field(examples=["angle of joint 4"])
    variable_unit: str = Field(examples=["deg"])
    quantity: str = Field(examples=["error of joint 4"])
    quantity_unit: str = Field(examples=["deg"])
    x: list[float | None]
    residual: list[float | None]
    standard_uncertainty: list[float | None]
    line_x: list[float | None]
    line: list[float | None]
    line_band: list[float | None] = Field(description="Half width of the 95 % band.")


class FindingDocument(Document):
    """One cause that the data show."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: float | None = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: float | None = Field(examples=[0.003])
    p_value: float | None = Field(description="Corrected for everything that was tried.")
    confidence: Confidence
    details: list[DetailDocument]
    sentence: str
    confusable_with: list[CauseDocument] = Field(description="What these data cannot tell from it.")
    gain: GainDocument | None
    share: float | None = Field(description="Of the structure explained: 0 to 1.")
    parameters: list[str] = Field(description="Their names in the extended model.")
    curve: CurveDocument | None


class DependenceDocument(Document):
    """Something that what is left depends on."""

    variable: str = Field(examples=["angle of joint 4"])
    p_value: float | None
    curve: CurveDocument | None


class RemainingDocument(Document):
    """What the extended model leaves."""

    structure: bool
    depends_on: list[DependenceDocument]
    sentence: str


class NextMeasurementDocument(Document):
    """What would tell causes apart; configurations can be added to a session."""

    sentence: str
    configurations_deg: list[list[float]]
    separates: list[CauseDocument]


class RuledOutDocument(Document):
    """A cause that was looked at and not found, or that these data cannot show."""

    effect: str
    subject: str
    reason: str
    p_value: float | None
    visible: bool = Field(description="False: these data cannot show it.")


class NoiseDocument(Document):
    """What the readings say of their own noise."""

    scale: float | None = Field(description="Scatter left over stated uncertainty.")
    tail_degrees_of_freedom: float | None = Field(description="Of Student's t; null: normal.")
    sentence: str


class DiagnosisDocument(Document):
    """What `truepose diagnose --json` prints."""

    robot: str
    verdict: Verdict
    message: str
    start_effects: list[str]
    findings: list[FindingDocument]
    quantity: str = Field(examples=["position"])
    before: StatisticsDocument | None
    after: StatisticsDocument | None
    held_out: HeldOut
    remaining: RemainingDocument
    next_measurements: list[NextMeasurementDocument]
    ruled_out: list[RuledOutDocument]
    withdrawn: list[str]
    noise: NoiseDocument | None


class DiagnosisRequest(Request):
    """A campaign to diagnose."""

    model_config = example({"campaign_id": 1, "effects": None, "measured_on": "2026-03-03"})

    campaign_id: Number
    effects: StartEffects = None
    measured_on: Day | None = Field(
        None,
        description="Day of the readings, by which diagnoses are compared over time. Null: when the "
        "session's last reading was stored, and of an uploaded campaign when it came.",
    )


class SessionDiagnosisRequest(Request):
    """What to diagnose a session with, beside its own readings."""

    model_config = example({"validation_session_id": 2})

    validation_session_id: Number | None = Field(
        None, description="Its readings judge the gain and nothing else.", examples=[2]
    )
    effects: StartEffects = None


class DiagnosisReply(Reply):
    """A stored diagnosis; its extended model is a model like any other."""

    id: RecordId
    recorded_at: RecordedAt
    measured_at: MeasuredAt
    job_id: RecordId
    campaign_id: RecordId
    session_id: RecordId | None = Field(description="Whose readings it is of; null: of an upload.")
    model_id: RecordId | None = Field(description="Null where nothing could be fitted.")
    robot_serial_number: str | None = Field(description="As the cell file said.", examples=["120-500123"])
    document: DiagnosisDocument


class FindingReply(Reply):
    """A finding in one line."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: float | None = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: float | None = Field(examples=[0.003])
    confidence: Confidence


class DiagnosisSummaryReply(Reply):
    """A stored diagnosis in a list: its first line and its findings."""

    id: RecordId
    recorded_at: RecordedAt
    measured_at: MeasuredAt
    job_id: RecordId
    campaign_id: RecordId
    session_id: RecordId | None
    model_id: RecordId | None
    robot: str = Field(examples=["ABB IRB 120"])
    robot_serial_number: str | None
    verdict: Verdict
    message: str
    findings: list[FindingReply]


class SignReply(Reply):
    """What one diagnosis says of a cause; numbers are null where it did not find it."""

    diagnosis_id: RecordId
    measured_at: MeasuredAt
    sighting: Sighting = Field(
        description="`not_visible`: these readings could not show it; `part_of_start`: the model had it."
    )
    amplitude: float | None = Field(examples=[0.021])
    amplitude_standard_uncertainty: float | None = Field(examples=[0.003])
    confidence: Confidence | None


class ChangeReply(Reply):
    """How far an amplitude changed between two diagnoses that found it, in its unit."""

    from_diagnosis_id: RecordId
    to_diagnosis_id: RecordId
    difference: float | None = Field(description="Later less earlier.", examples=[0.012])
    standard_uncertainty: float | None = Field(examples=[0.004])
    p_value: float | None = Field(description="Corrected for all changes of the reply; null: not tested.")
    significant: bool = Field(description="The change is more than noise explains (level 5 % in all).")
    sentence: str


class CauseReply(Reply):
    """A cause in all diagnoses, oldest readings first."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    order: float | None = Field(description="Waves per turn; null where the cause is no wave.")
    unit: str = Field(examples=["deg"])
    signs: list[SignReply]
    changes: list[ChangeReply] = Field(description="Between consecutive diagnoses that found it.")
    overall: ChangeReply | None = Field(description="From the first to the last, where there are more.")


class ComparisonReply(Reply):
    """How the causes on one robot changed over time."""

    robot: str = Field(examples=["ABB IRB 120"])
    diagnoses: list[DiagnosisSummaryReply] = Field(
        description="What was compared, oldest readings first; the latest of those of the same readings."
    )
    causes: list[CauseReply]


def diagnosis_reply(record: DiagnosisRecord) -> DiagnosisReply:
    """Return a diagnosis as it travels."""
    document: dict[str, Any] = diagnosis_document(record.diagnosis)
    return DiagnosisReply(
        id=record.id,
        recorded_at=record.recorded_at,
        measured_at=record.measured_at,
        job_id=record.job_id,
        campaign_id=record.campaign_id,
        session_id=record.session_id,
        model_id=record.model_id,
        robot_serial_number=record.robot_serial_number or None,
        document=DiagnosisDocument.model_validate(document),
    )


def diagnosis_summary_reply(record: DiagnosisRecord) -> DiagnosisSummaryReply:
    """Return a diagnosis as it stands in a list."""
    found = record.diagnosis
    return DiagnosisSummaryReply(
        id=record.id,
        recorded_at=record.recorded_at,
        measured_at=record.measured_at,
        job_id=record.job_id,
        campaign_id=record.campaign_id,
        session_id=record.session_id,
        model_id=record.model_id,
        robot=found.robot,
        robot_serial_number=record.robot_serial_number or None,
        verdict=found.verdict,
        message=found.message,
        findings=[_finding(finding) for finding in found.findings],
    )


def _finding(finding: Finding) -> FindingReply:
    return FindingReply(
        effect=finding.effect,
        subject=finding.subject,
        amplitude=known(finding.amplitude),
        unit=finding.unit,
        amplitude_standard_uncertainty=known(finding.amplitude_standard_uncertainty),
        confidence=finding.confidence,
    )


def comparison_reply(
    robot: str, records: Sequence[DiagnosisRecord], causes: Sequence[CauseOverTime]
) -> ComparisonReply:
    """Return a comparison as it travels."""
    return ComparisonReply(
        robot=robot,
        diagnoses=[diagnosis_summary_reply(record) for record in records],
        causes=[_cause(cause) for cause in causes],
    )


def _cause(cause: CauseOverTime) -> CauseReply:
    return CauseReply(
        effect=cause.effect,
        subject=cause.subject,
        order=cause.order,
        unit=cause.unit,
        signs=[_sign(sign) for sign in cause.signs],
        changes=[_change(change) for change in cause.changes],
        overall=None if cause.overall is None else _change(cause.overall),
    )


def _sign(sign: Sign) -> SignReply:
    return SignReply(
        diagnosis_id=sign.diagnosis_id,
        measured_at=sign.measured_at,
        sighting=sign.sighting,
        amplitude=None if sign.amplitude is None else known(sign.amplitude),
        amplitude_standard_uncertainty=(
            None if sign.standard_uncertainty is None else known(sign.standard_uncertainty)
        ),
        confidence=sign.confidence,
    )


def _change(change: Change) -> ChangeReply:
    return ChangeReply(
        from_diagnosis_id=change.from_id,
        to_diagnosis_id=change.to_id,
        difference=known(change.difference),
        standard_uncertainty=known(change.standard_uncertainty),
        p_value=change.p_value,
        significant=change.significant,
        sentence=change.sentence,
    )
