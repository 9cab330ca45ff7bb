"""Diagnoses: requests and records."""

from typing import Annotated

from pydantic import Field

from truepose.domain.results.diagnosis import Confidence, Verdict
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.diagnosis import DiagnosisDocument
from truepose.exchange.results.document_base import Spoken
from truepose.storage.records import DiagnosisRecord
from truepose.web.schemas.base import (
    Day,
    Number,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    Simulated,
    example,
)
from truepose.web.schemas.calibration.results import EffectNames

StartEffects = Annotated[
    EffectNames | None,
    Field(
        description="Effects of the model that the diagnosis starts from; none of them is a finding. "
        "Null: base, tool as far as unknown, geometry and compliance.",
    ),
]
MeasuredAt = Annotated[
    str | None,
    Field(
        description="When the readings were taken: a day, or UTC in ISO 8601. Null: nobody said.",
        examples=["2026-03-03"],
    ),
]


class DiagnosisRequest(Request):
    """A campaign to diagnose."""

    model_config = example({"campaign_id": 1, "effects": None, "measured_on": "2026-03-03"})

    campaign_id: Number
    effects: StartEffects = None
    measured_on: Day | None = Field(
        None,
        description="Day of the readings, by which diagnoses are compared over time. Null: the day that the "
        "campaign states, or when the session's last reading was stored; else it is not known.",
    )


class SessionDiagnosisRequest(Request):
    """What to diagnose a session with, beside its own readings."""

    model_config = example({"validation_session_id": 2})

    validation_session_id: Number | None = Field(
        None, description="Its readings judge the gain and nothing else.", examples=[2]
    )
    effects: StartEffects = None


class StoredDiagnosis(Reply):
    """Whose diagnosis it is, and when it was made."""

    id: RecordId
    recorded_at: RecordedAt
    measured_at: MeasuredAt
    simulated: Simulated
    job_id: RecordId
    campaign_id: RecordId
    session_id: RecordId | None = Field(description="Whose readings it is of; null: of an upload.")
    model_id: RecordId | None = Field(description="Null where nothing could be fitted.")
    robot_serial_number: str | None = Field(description="As the cell file said.", examples=["120-500123"])


class DiagnosisReply(StoredDiagnosis):
    """A stored diagnosis; its extended model is a model like any other."""

    document: DiagnosisDocument


class FindingReply(Reply):
    """A finding in one line."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: Quantity = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: Quantity = Field(examples=[0.003])
    confidence: Confidence


class DiagnosisSummaryReply(StoredDiagnosis):
    """A stored diagnosis in a list: its first line and its findings."""

    robot: str = Field(examples=["ABB IRB 120"])
    verdict: Verdict
    message: Spoken
    findings: list[FindingReply]


def diagnosis_reply(record: DiagnosisRecord) -> DiagnosisReply:
    """Return a diagnosis as it travels."""
    serial_number = record.robot_serial_number or None
    return DiagnosisReply.of(record, robot_serial_number=serial_number, document=record.diagnosis)


def diagnosis_summary_reply(record: DiagnosisRecord) -> DiagnosisSummaryReply:
    """Return a diagnosis as it stands in a list."""
    serial_number = record.robot_serial_number or None
    return DiagnosisSummaryReply.of(record, record.diagnosis, robot_serial_number=serial_number)
