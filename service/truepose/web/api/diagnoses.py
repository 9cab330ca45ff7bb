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
from truepose.web.api.identifications import (
    EffectNames,
    KeepSetAside,
    SetAside,
    readings_to_set_aside,
)
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
        description="Effects included in the initial model; none of them is reported as a finding. Null: "
        "base, unknown tool parameters, geometry and compliance.",
    ),
]
MeasuredAt = Annotated[
    str | None,
    Field(
        description="Time of the readings: a date, or UTC in ISO 8601. Null if not stated.",
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
        description="Date of the readings, used to compare diagnoses over time. Null: the date stated in "
        "the campaign, or the time of the session's last reading; otherwise unknown.",
    )
    set_aside: SetAside = None
    keep_set_aside: KeepSetAside = False


class SessionDiagnosisRequest(Request):
    """Additional input for the diagnosis of a session."""

    model_config = example({"validation_session_id": 2})

    validation_session_id: Number | None = Field(
        None,
        description="Validation session; its readings are used only to judge the improvement.",
        examples=[2],
    )
    effects: StartEffects = None
    keep_set_aside: bool = Field(
        True,
        description="Exclude the readings that the session's latest identification or diagnosis excluded, "
        "by the same person for the same reason; false to use all readings.",
    )


class StoredDiagnosis(Reply):
    """Source and time of a stored diagnosis."""

    id: RecordId
    recorded_at: RecordedAt
    measured_at: MeasuredAt
    simulated: Simulated
    job_id: RecordId
    campaign_id: RecordId
    session_id: RecordId | None = Field(description="Session that provided the readings; null for an upload.")
    model_id: RecordId | None = Field(
        description="Number of the extended model; null if nothing could be fitted."
    )
    robot_serial_number: Annotated[str | None, null_if_empty("robot_serial_number")] = Field(
        description="Serial number of the robot, from the cell file.", examples=["120-500123"]
    )


class DiagnosisReply(StoredDiagnosis):
    """A stored diagnosis; its extended model can be used like any other model."""

    document: Annotated[DiagnosisDocument, FieldSource("diagnosis")]


class FindingReply(Reply):
    """Summary of a finding."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    amplitude: Quantity = Field(examples=[0.021])
    unit: str = Field(examples=["deg"])
    amplitude_standard_uncertainty: Quantity = Field(examples=[0.003])
    confidence: Confidence


class DiagnosisSummaryReply(StoredDiagnosis):
    """Summary of a stored diagnosis for lists: its verdict and findings."""

    robot: Annotated[str, FieldSource("diagnosis.robot")] = Field(examples=["ABB IRB 120"])
    verdict: Annotated[Verdict, FieldSource("diagnosis.verdict")]
    message: Annotated[Spoken, FieldSource("diagnosis.message")]
    findings: Annotated[list[FindingReply], FieldSource("diagnosis.findings")]


class SignReply(Reply):
    """Result of one diagnosis for a cause; numbers are null if the cause was not found."""

    diagnosis_id: RecordId
    measured_at: MeasuredAt
    sighting: Sighting = Field(
        description="`not_visible`: the readings could not show the cause; `part_of_start`: the initial "
        "model included the cause."
    )
    amplitude: Quantity = Field(examples=[0.021])
    amplitude_standard_uncertainty: Annotated[Quantity, FieldSource("standard_uncertainty")] = Field(
        examples=[0.003]
    )
    confidence: Confidence | None


class ChangeReply(Reply):
    """Change of an amplitude between two diagnoses that found the cause, in its unit."""

    from_diagnosis_id: Annotated[RecordId, FieldSource("from_id")]
    to_diagnosis_id: Annotated[RecordId, FieldSource("to_id")]
    difference: Quantity = Field(description="Later minus earlier amplitude.", examples=[0.012])
    standard_uncertainty: Quantity = Field(examples=[0.004])
    p_value: float | None = Field(
        description="p-value, corrected for all changes in the reply; null if not tested."
    )
    significant: bool = Field(
        description="True if the change exceeds the noise (5 % level over all changes)."
    )
    sentence: str


class VariantReply(Reply):
    """Variant of a cause that can act in several ways."""

    name: str = Field(
        description="`order` of a joint harmonic or `source joint` of a coupling.", examples=["order"]
    )
    value: float = Field(examples=[2.0])


class CauseReply(Reply):
    """A cause in all diagnoses, oldest readings first."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    variant: VariantReply | None = Field(
        description="Variant of the cause; null if the cause has only one variant."
    )
    unit: str = Field(examples=["deg"])
    signs: list[SignReply]
    changes: list[ChangeReply] = Field(
        description="Changes between consecutive diagnoses that found the cause."
    )
    overall: ChangeReply | None = Field(
        description="Change from the first to the last diagnosis; null for two diagnoses or fewer."
    )


class AlarmReply(Reply):
    """A cause that has grown significantly."""

    effect: str = Field(examples=["backlash"])
    subject: str = Field(examples=["joint 3"])
    kind: Literal["grown", "appeared"]
    sentence: str


class ComparisonReply(Reply):
    """Changes of the error sources of one robot over time."""

    robot: str = Field(examples=["ABB IRB 120"])
    diagnoses: list[DiagnosisSummaryReply] = Field(
        description="Diagnoses compared, oldest readings first, undated ones last; for identical readings, "
        "only the latest."
    )
    undated_ids: list[int] = Field(
        description="Diagnoses without a date of the readings; they are last in the list, and no "
        "differences are computed from them."
    )
    causes: list[CauseReply]
    alarms: list[AlarmReply] = Field(
        description="Causes to check first during service; empty if none has grown."
    )


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
    Query(
        min_length=1, max_length=200, description="Robot name, as in its diagnoses.", examples=["ABB IRB 120"]
    ),
]
SerialNumber = Annotated[
    str | None,
    Query(
        min_length=1,
        max_length=200,
        description="Serial number of the robot; required if several robots have this name.",
        examples=["120-500123"],
    ),
]


@router.post("/diagnoses", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def diagnose_campaign(
    here: Here, wanted: DiagnosisRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Diagnose a campaign in a worker process; the result of the job is the diagnosis."""
    effects = _named(wanted.effects)
    aside = await readings_to_set_aside(
        here, wanted.campaign_id, wanted.set_aside, keep=wanted.keep_set_aside
    )
    number = await here.job_desk.diagnose(
        wanted.campaign_id, effects, wanted.measured_on, key, sender, set_aside=aside
    )
    return await queued_job(here, number, response)


@router.post("/sessions/{id}/diagnosis", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def diagnose_session(
    here: Here, id: Id, wanted: SessionDiagnosisRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Diagnose the readings of a calibration session so far, whether finished, paused or running.

    The readings are stored as a campaign; after further readings, a new request makes a new diagnosis.
    Readings that were set aside before stay set aside, unless the request says otherwise.
    """
    # Before anything is kept: an effect that nobody knows must not leave a campaign behind.
    effects = _named(wanted.effects)
    name = (await here.sessions.get(id)).name
    # A client's key has no blank, so this one belongs to the campaign of the same request and no other.
    campaign_key = None if key is None else RequestKey(f"{key.key} campaign", key.fingerprint)
    campaign_id = await here.campaign_desk.from_sessions(name, id, wanted.validation_session_id, campaign_key)
    aside = await here.set_aside.of_session(id) if wanted.keep_set_aside else None
    number = await here.job_desk.diagnose(campaign_id, effects, key=key, sender=sender, set_aside=aside)
    return await queued_job(here, number, response)


@router.get("/diagnoses", responses=LIST)
async def list_diagnoses(here: Here, paging: Paged) -> list[DiagnosisSummaryReply]:
    """List diagnoses, oldest first, each with its verdict and findings."""
    return paging.shown(await here.diagnoses.page(paging.page), DiagnosisSummaryReply.of)


@router.get("/diagnoses/comparison", responses=ACT)
async def compare_diagnoses(
    here: Here, robot: RobotName, serial_number: SerialNumber = None
) -> ComparisonReply:
    """Compare the error sources of one robot over time: amplitudes, and which changes exceed the noise."""
    records, causes = compare_over_time(robot, await here.diagnoses.of_robot(robot, serial_number))
    return comparison_reply(robot, records, causes)


@router.get("/diagnoses/{id}", responses=READ)
async def get_diagnosis(here: Here, id: Id) -> DiagnosisReply:
    """Return a diagnosis, as printed by `truepose diagnose --json`."""
    return DiagnosisReply.of(await here.diagnoses.get(id))


def _named(effects: list[str] | None) -> tuple[str, ...] | None:
    """Return the effects to start from; raises UnknownEffectError."""
    return None if effects is None else chosen_effects(effects)
