"""Diagnoses: ask for one, read the answer, compare those of one robot over time."""

from typing import Annotated

from fastapi import Query, Response, status

from truepose.analysis.comparison import compare_over_time
from truepose.effects.registry import chosen_effects
from truepose.storage.records import RequestKey
from truepose.web.context import Here
from truepose.web.jobs import queued
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, OptionalKey, Sender
from truepose.web.resources import resource
from truepose.web.schemas.calibration.comparisons import ComparisonReply, comparison_reply
from truepose.web.schemas.calibration.diagnoses import (
    DiagnosisReply,
    DiagnosisRequest,
    DiagnosisSummaryReply,
    SessionDiagnosisRequest,
    diagnosis_reply,
    diagnosis_summary_reply,
)
from truepose.web.schemas.jobs import JobReply

router = resource(tags=["diagnoses"])
_ASKED = problems(400, 404, 409, 413, 415, 422, 503)
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


@router.post("/diagnoses", status_code=status.HTTP_202_ACCEPTED, responses=_ASKED)
async def diagnose_campaign(
    here: Here, wanted: DiagnosisRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Diagnose a campaign in a worker process; the job's result is the diagnosis."""
    effects = _named(wanted.effects)
    number = await here.job_desk.diagnose(wanted.campaign_id, effects, wanted.measured_on, key, sender)
    return await queued(here, number, response)


@router.post("/sessions/{id}/diagnosis", status_code=status.HTTP_202_ACCEPTED, responses=_ASKED)
async def diagnose_session(
    here: Here, id: Id, wanted: SessionDiagnosisRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Diagnose what a calibration session has measured so far, be it finished, paused or running.

    Its readings are kept as a campaign; after more of them a further request makes a further diagnosis.
    """
    effects = _named(wanted.effects)
    name = (await here.sessions.get(id)).name
    # A client's key has no blank, so this one belongs to the campaign of the same request and no other.
    campaign_key = None if key is None else RequestKey(f"{key.key} campaign", key.fingerprint)
    campaign_id = await here.campaign_desk.from_sessions(name, id, wanted.validation_session_id, campaign_key)
    number = await here.job_desk.diagnose(campaign_id, effects, key=key, sender=sender)
    return await queued(here, number, response)


@router.get("/diagnoses", responses=listing(422, 503))
async def list_diagnoses(here: Here, paging: Paged) -> list[DiagnosisSummaryReply]:
    """List diagnoses, oldest first, each with its first line and its findings."""
    return paging.shown(await here.diagnoses.page(paging.page), diagnosis_summary_reply)


@router.get("/diagnoses/comparison", responses=problems(404, 409, 422, 503))
async def compare_diagnoses(
    here: Here, robot: RobotName, serial_number: SerialNumber = None
) -> ComparisonReply:
    """Say how the causes on one robot changed: amplitudes over time, and which change is more than noise."""
    records, causes = compare_over_time(robot, await here.diagnoses.of_robot(robot, serial_number))
    return comparison_reply(robot, records, causes)


@router.get("/diagnoses/{id}", responses=problems(404, 422, 503))
async def get_diagnosis(here: Here, id: Id) -> DiagnosisReply:
    """Show a diagnosis: the document that `truepose diagnose --json` prints."""
    return diagnosis_reply(await here.diagnoses.get(id))


def _named(effects: list[str] | None) -> tuple[str, ...] | None:
    """Return the effects to start from; raises UnknownEffectError."""
    return None if effects is None else chosen_effects(effects)
