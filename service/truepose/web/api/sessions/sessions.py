"""Sessions of every kind: planned, listed, shown, added to, and what their readings say."""

import math
from dataclasses import replace
from typing import Any, Final

from fastapi import Response, status

from truepose.analysis.campaigns.records import circles_by_session, proof_by_session
from truepose.domain.session import Registration
from truepose.exchange.results.circles_and_spheres import (
    CircleTestDocument,
    SphereTestDocument,
    circle_document,
    sphere_document,
)
from truepose.exchange.results.corrections import ProofDocument, proof_document
from truepose.exchange.results.validation import AccuracyDocument, accuracy_document
from truepose.messages.message import key_of, message
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.storage.errors import ConflictError
from truepose.storage.records import SessionRecord
from truepose.web.api.authority import require_authority
from truepose.web.api.jobs import JobReply, queued_job
from truepose.web.api.sessions.added_stops import (
    AdditionReply,
    AdditionRequest,
    addition_reply,
    wanted_stops,
)
from truepose.web.api.sessions.kind import PlanningRequest
from truepose.web.api.sessions.kinds import AnySessionRequest, kind_called
from truepose.web.api.sessions.schemas import (
    ProgressReply,
    RegistrationReply,
    SessionDetailReply,
    SessionReply,
)
from truepose.web.api.sessions.situations import prompt_reply
from truepose.web.context import Context, Here
from truepose.web.middleware.language import in_words
from truepose.web.pages.accuracy_results import accuracy_of
from truepose.web.pages.geometry_results import sphere_of
from truepose.web.pages.session_results import Chosen, origin_of
from truepose.web.resources import (
    ACT,
    CHANGE,
    LIST,
    READ,
    Id,
    ModelId,
    ModelIds,
    OptionalKey,
    Paged,
    resource,
)

router = resource("/sessions", tags=["sessions"])
_PLANNED: Final[dict[int | str, dict[str, Any]]] = {
    201: {"model": SessionDetailReply, "description": "The session has been planned; nothing has moved."},
    202: {
        "model": JobReply,
        "description": "A worker chooses the configurations; the result of the job is the session.",
    },
}


@router.post(
    "",
    status_code=status.HTTP_201_CREATED,
    response_model=SessionDetailReply | JobReply,
    responses=_PLANNED | CHANGE,
)
async def plan_session(
    here: Here, wanted: AnySessionRequest, response: Response, planning: PlanningRequest
) -> SessionDetailReply | JobReply:
    """Plan a session of any kind, with given configurations (201) or chosen ones (201, or 202 with a job).

    Nothing moves. The configurations of a tracker session are chosen by a job; those of a contact or ballbar
    session immediately, within a minute, or by a job with `Prefer: respond-async`. Given configurations are
    refused if the path between them would make the arm hit the floor, the table or itself and the cell file
    states the floor; otherwise the `notes` of the session warn of it, as does the prompt before the motion.
    """
    made = await kind_called(wanted.kind).plan(here, wanted, planning)
    if made.by_job:
        response.status_code = status.HTTP_202_ACCEPTED
        return await queued_job(here, made.number, response, preferred=planning.later)
    response.headers["Location"] = f"/api/v1/sessions/{made.number}"
    return await get_session(here, made.number)


@router.get("/{id}/proof", responses=ACT)
async def get_proof(here: Here, id: Id, model_id: ModelId) -> ProofDocument:
    """Return the result of a proof move: how much the correction by a model improves the accuracy."""
    model = (await here.results.model(model_id)).model
    return proof_document(await proof_by_session(here.sessions, here.readings, id, model))


@router.get("/{id}/circles", responses=ACT)
async def get_circles(here: Here, id: Id) -> CircleTestDocument:
    """Return the errors of each joint, from a circle test."""
    found = await circles_by_session(here.sessions, here.readings, id)
    return circle_document(found, (await here.sessions.setup(id)).cell.robot.name)


@router.get("/{id}/sphere", responses=ACT)
async def get_sphere(here: Here, id: Id, model_id: ModelIds) -> SphereTestDocument:
    """Return the result of a sphere test with the ballbar; available while the session runs.

    It covers the nominal robot, the requested models, and the model that commanded the arm.
    """
    test, robot = await sphere_of(here, id, model_id)
    return sphere_document(test, robot)


@router.get("/{id}/accuracy", responses=ACT)
async def get_accuracy(here: Here, id: Id, choice: Chosen) -> AccuracyDocument:
    """Validate a model on the points of a session; an ISO 9283 test includes its characteristics."""
    _, found = await accuracy_of(here, await origin_of(here, id), choice)
    return accuracy_document(found.validation, found.test)


@router.get("", responses=LIST)
async def list_sessions(here: Here, paging: Paged) -> list[SessionReply]:
    """List sessions, oldest first."""
    return paging.shown(await here.sessions.page(paging.page), lambda record: _reply(here, record))


@router.get("/{id}", responses=READ)
async def get_session(here: Here, id: Id) -> SessionDetailReply:
    """Return a session with its progress and history."""
    shown = await _shown(here, id)
    progress = await here.sessions.progress(id)
    registration = await here.sessions.registration(id)
    return SessionDetailReply.of(
        shown,
        progress=progress,
        states=await here.sessions.states(id),
        skipped_stops=await here.sessions.skipped(id),
        registration=None if registration is None else _registration(registration),
        identities=await here.sessions.identities(id),
        notes=await here.sessions.notes(id),
    )


@router.get("/{id}/progress", responses=READ)
async def get_progress(here: Here, id: Id) -> ProgressReply:
    """Return the progress of a session; follow `events` instead of polling."""
    record = await here.sessions.get(id)
    progress = await here.sessions.progress(id)
    if progress is not None:
        return ProgressReply.of(progress)
    return ProgressReply(
        done=0,
        skipped=0,
        planned=record.planned,
        elapsed_s=0.0,
        remaining_s=None,
        doing=in_words(record.reason),
    )


@router.post("/{id}/configurations", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def add_configurations(
    here: Here, id: Id, wanted: AdditionRequest, response: Response, key: OptionalKey
) -> AdditionReply:
    """Add configurations to a session that has not ended, such as those proposed by a diagnosis.

    They are checked like planned ones and measured after all others, once a person has confirmed that the
    cell is clear for them.
    """
    await require_authority(here, id, CommandName.SKIP)
    await _check_proposed(here, id, wanted.diagnosis_id)
    found = await here.tracker_sessions.add_stops(id, wanted_stops(wanted), wanted.person, key)
    response.headers["Location"] = f"/api/v1/sessions/{id}/plan"
    return addition_reply(found, await _shown(here, id))


async def _check_proposed(here: Context, session_id: int, diagnosis_id: int | None) -> None:
    """Raise NotFoundError for a diagnosis that is not there, ConflictError for one of other readings."""
    if diagnosis_id is not None and (await here.diagnoses.get(diagnosis_id)).session_id != session_id:
        raise ConflictError(message("refused.other_diagnosis", diagnosis=diagnosis_id, session=session_id))


async def _shown(here: Context, number: int) -> SessionReply:
    return _reply(here, await here.sessions.get(number))


def _reply(here: Context, record: SessionRecord) -> SessionReply:
    # The record was read a moment ago, and a line is on disk before the runner goes by it.
    under_way, now = here.session_desk.under_way(record.id), here.session_desk.attendance(record.id)
    runner = None if under_way is None else under_way.runner
    if runner is not None:
        moment = runner.moment
        record = replace(record, state=moment.state, reason=moment.reason)
    return SessionReply.of(
        record,
        reason_key=key_of(record.reason),
        tracker_in_question=runner.tracker_in_question if isinstance(runner, TrackerRunner) else None,
        prompt=prompt_reply(record.id, now.prompt),
        trouble=now.trouble,
        motion_notice=now.motion_notice,
    )


def _registration(found: Registration) -> RegistrationReply:
    rms_mm = found.rms_mm if math.isfinite(found.rms_mm) else None
    return RegistrationReply.of(found, tracker_position_mm=found.translation_mm.tolist(), rms_mm=rms_mm)
