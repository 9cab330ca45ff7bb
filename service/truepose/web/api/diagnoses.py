"""Diagnoses: ask for one, read the answer, compare those of one robot over time."""

from collections.abc import Sequence
from typing import Annotated, Literal

from fastapi import Query, Response, status
from pydantic import Field

from truepose.analysis.comparison import compare_over_time, dated_diagnoses
from truepose.diagnosis.alarms import Alarm, NewCause, alarms
from truepose.diagnosis.history import CauseOverTime, Change, Sighting
from truepose.domain.diagnosis import Confidence, Verdict
from truepose.effects.registry import chosen_effects
from truepose.exchange.results.diagnosis import DiagnosisDocument
from truepose.exchange.results.document import FieldSource, Quantity, Spoken, null_if_empty
from truepose.messages.catalogue import IN_ENGLISH
from truepose.storage.records import DiagnosisRecord, RequestKey
from truepose.web.api.identifications import EffectNames
from truepose.web.api.jobs import JobReply, queued_job
from truepose.web.context import Here
from truepose.web.resources import ACT, CHANGE, LIST, READ, Id, OptionalKey, Paged, Sender, resource
from truepose.web.schemas import (
    Day,
    Number,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    Simulated,
    example,
)

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
    robot_serial_number: Annotated[str | None, null_if_empty("robot_serial_number")] = Field(
        description="As the cell file said.", examples=["120-500123"]
    )


class DiagnosisReply(StoredDiagnosis):
    """A stored diagnosis; its extended model is a model like any other."""

    document: Annotated[DiagnosisDocument, FieldSource("diagnosis")]


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

    robot: Annotated[str, FieldSource("diagnosis.robot")] = Field(examples=["ABB IRB 120"])
    verdict: Annotated[Verdict, FieldSource("diagnosis.verdict")]
    message: Annotated[Spoken, FieldSource("diagnosis.message")]
    findings: Annotated[list[FindingReply], FieldSource("diagnosis.findings")]


class SignReply(Reply):
    """What one diagnosis says of a cause; numbers are null where it did not find it."""

    diagnosis_id: RecordId
    measured_at: MeasuredAt
    sighting: Sighting = Field(
        description="`not_visible`: these readings could not show it; `part_of_start`: the model had it."
    )
    amplitude: Quantity = Field(examples=[0.021])
    amplitude_standard_uncertainty: Annotated[Quantity, FieldSource("standard_uncertainty")] = Field(
        examples=[0.003]
    )
    confidence: Confidence | None


class ChangeReply(Reply):
    """How far an amplitude changed between two diagnoses that found it, in its unit."""

    from_diagnosis_id: Annotated[RecordId, FieldSource("from_id")]
    to_diagnosis_id: Annotated[RecordId, FieldSource("to_id")]
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
    return ComparisonReply.of(
        robot=robot,
        diagnoses=records,
        undated_ids=[record.id for record in records if record.measured_at is None],
        causes=[_cause(cause) for cause in causes],
        alarms=[_alarm(alarm) for alarm in alarms(causes, dated_diagnoses(records))],
    )


def _cause(cause: CauseOverTime) -> CauseReply:
    changes = [_change(cause, change) for change in cause.changes]
    overall = None if cause.overall is None else _change(cause, cause.overall)
    return CauseReply.of(cause, changes=changes, overall=overall)


def _change(cause: CauseOverTime, change: Change) -> ChangeReply:
    from truepose.reports.history_sentences import change_words

    return ChangeReply.of(change, sentence=change_words(cause, change, IN_ENGLISH))


def _alarm(alarm: Alarm) -> AlarmReply:
    from truepose.reports.history_sentences import alarm_words

    return AlarmReply(
        effect=alarm.cause.effect,
        subject=alarm.cause.subject,
        kind="appeared" if isinstance(alarm, NewCause) else "grown",
        sentence=alarm_words(alarm, IN_ENGLISH),
    )


router = resource(tags=["diagnoses"])
RobotName = Annotated[
    str,
    Query(min_length=1, max_length=200, description="As its diagnoses name it.", examples=["ABB IRB 120"]),
]
SerialNumber = Annotated[
    str | None,
    Query(
        min_length=1,
        max_length=200,
        description="Only the robot of this serial number; needed where there are several of that name.",
        examples=["120-500123"],
    ),
]


@router.post("/diagnoses", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def diagnose_campaign(
    here: Here, wanted: DiagnosisRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Diagnose a campaign in a worker process; the job's result is the diagnosis."""
    effects = _named(wanted.effects)
    number = await here.job_desk.diagnose(wanted.campaign_id, effects, wanted.measured_on, key, sender)
    return await queued_job(here, number, response)


@router.post("/sessions/{id}/diagnosis", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def diagnose_session(
    here: Here, id: Id, wanted: SessionDiagnosisRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Diagnose what a calibration session has measured so far, be it finished, paused or running.

    Its readings are kept as a campaign; after more of them a further request makes a further diagnosis.
    """
    # Before anything is kept: an effect that nobody knows must not leave a campaign behind.
    effects = _named(wanted.effects)
    name = (await here.sessions.get(id)).name
    # A client's key has no blank, so this one belongs to the campaign of the same request and no other.
    campaign_key = None if key is None else RequestKey(f"{key.key} campaign", key.fingerprint)
    campaign_id = await here.campaign_desk.from_sessions(name, id, wanted.validation_session_id, campaign_key)
    number = await here.job_desk.diagnose(campaign_id, effects, key=key, sender=sender)
    return await queued_job(here, number, response)


@router.get("/diagnoses", responses=LIST)
async def list_diagnoses(here: Here, paging: Paged) -> list[DiagnosisSummaryReply]:
    """List diagnoses, oldest first, each with its first line and its findings."""
    return paging.shown(await here.diagnoses.page(paging.page), DiagnosisSummaryReply.of)


@router.get("/diagnoses/comparison", responses=ACT)
async def compare_diagnoses(
    here: Here, robot: RobotName, serial_number: SerialNumber = None
) -> ComparisonReply:
    """Say how the causes on one robot changed: amplitudes over time, and which change is more than noise."""
    records, causes = compare_over_time(robot, await here.diagnoses.of_robot(robot, serial_number))
    return comparison_reply(robot, records, causes)


@router.get("/diagnoses/{id}", responses=READ)
async def get_diagnosis(here: Here, id: Id) -> DiagnosisReply:
    """Show a diagnosis: the document that `truepose diagnose --json` prints."""
    return DiagnosisReply.of(await here.diagnoses.get(id))


def _named(effects: list[str] | None) -> tuple[str, ...] | None:
    """Return the effects to start from; raises UnknownEffectError."""
    return None if effects is None else chosen_effects(effects)
