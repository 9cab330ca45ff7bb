"""Sessions: plan, start, confirm, pause, resume, abort, watch."""

import asyncio
import math
from dataclasses import replace
from typing import Annotated

from fastapi import Body, Response, status

from truepose.analysis.campaigns.measured import circles_by_session, proof_by_session
from truepose.analysis.workers.tasks import PlanTask
from truepose.domain.measurement.session import Registration, SessionPlan
from truepose.exchange.results.circles import CircleTestDocument, circle_document
from truepose.exchange.results.iso9283 import AccuracyDocument, accuracy_document
from truepose.exchange.results.proofs import ProofDocument, proof_document
from truepose.exchange.results.spheres import SphereTestDocument, sphere_document
from truepose.operation.tracker.plans import judged
from truepose.sequencing.engine.acts import Act, ActName
from truepose.sequencing.tracker.runner import TrackerRunner
from truepose.storage.errors import ConflictError
from truepose.storage.records import RequestKey, SessionRecord, SessionSetup
from truepose.web.context import Context, Here
from truepose.web.jobs import planned_or_queued, queued
from truepose.web.people.asking import signed_in_name
from truepose.web.people.authority import require_authority
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, ModelId, ModelIds, OptionalKey, Sender
from truepose.web.requests.pressed import under_way_s
from truepose.web.resources import resource
from truepose.web.results.accuracy import accuracy_of
from truepose.web.results.choices import Chosen
from truepose.web.results.origins import origin_of
from truepose.web.results.sphere import sphere_of
from truepose.web.schemas.jobs import JobReply
from truepose.web.schemas.measurement.additions import (
    AdditionReply,
    AdditionRequest,
    addition_reply,
    wanted_stops,
)
from truepose.web.schemas.measurement.identities import identity_reply
from truepose.web.schemas.measurement.sessions import (
    ActionReply,
    AnswerRequest,
    ChosenStops,
    CircleStops,
    ConfirmRequest,
    GivenStops,
    PlanReply,
    PoseStops,
    ProgressReply,
    ProvingStops,
    RegistrationReply,
    RequestOfPerson,
    SessionDetailReply,
    SessionReply,
    SessionRequest,
    plan_task,
    planned,
)

router = resource("/sessions", tags=["sessions"])
_READ = problems(404, 422, 503)
_ACT = problems(400, 404, 409, 413, 415, 422, 503)
Anybody = Annotated[RequestOfPerson | None, Body()]


@router.post(
    "",
    status_code=status.HTTP_201_CREATED,
    response_model=SessionDetailReply | JobReply,
    responses=planned_or_queued(
        SessionDetailReply, "A worker chooses the configurations; the job's result is the session."
    )
    | problems(400, 404, 409, 413, 415, 422, 503),
)
async def plan_session(
    here: Here, wanted: SessionRequest, response: Response, key: OptionalKey, sender: Sender
) -> SessionDetailReply | JobReply:
    """Plan a session: with configurations given (201), or to be chosen by a job (202). Nothing moves.

    A way between given configurations on which the arm would touch floor, table or itself is refused where
    the cell states its floor; else the `notes` of the session say so, and the question before it moves.
    """
    setup = SessionSetup(here.cell, wanted.attachment)
    plan = planned(wanted, here.cell)
    if isinstance(wanted.plan, GivenStops):
        notice = await asyncio.to_thread(judged, here.cell, plan)
        number = await here.sessions.add(wanted.name, setup, plan, key)
        if notice and notice not in await here.sessions.notes(number):  # a repeated request finds it there
            await here.sessions.note(number, notice)
        response.headers["Location"] = f"/api/v1/sessions/{number}"
        return await get_session(here, number)
    number = await _queue_plan(here, wanted, setup, plan, key, sender)
    response.status_code = status.HTTP_202_ACCEPTED
    return await queued(here, number, response)


async def _queue_plan(
    here: Context,
    wanted: SessionRequest,
    setup: SessionSetup,
    plan: SessionPlan,
    key: RequestKey | None,
    sender: str,
) -> int:
    match wanted.plan:
        case ProvingStops(model_id=model_id, targets=targets, seed=seed):
            _require_validation(wanted)
            proved = (await here.results.model(model_id)).model
            task = PlanTask(setup, plan, targets, seed, proved)
            return await here.job_desk.plan(wanted.name, task, key, model_id, sender)
        case ChosenStops(configurations=configurations, seed=seed):
            task = PlanTask(setup, plan, configurations, seed)
            return await here.job_desk.plan(wanted.name, task, key, sender=sender)
        case CircleStops() | PoseStops() as test:
            _require_validation(wanted)
            return await here.job_desk.plan(wanted.name, plan_task(test, setup, plan), key, sender=sender)
    raise AssertionError("given stops are no job")


def _require_validation(wanted: SessionRequest) -> None:
    if wanted.role != "validation":
        raise ConflictError(
            'The readings of a proof or a test judge and never identify: its role is "validation".'
        )


@router.get("/{id}/proof", responses=problems(404, 409, 422, 503))
async def get_proof(here: Here, id: Id, model_id: ModelId) -> ProofDocument:
    """Say what the corrections of a model are worth, by a session that was planned to prove it."""
    model = (await here.results.model(model_id)).model
    return proof_document(await proof_by_session(here.sessions, here.readings, id, model))


@router.get("/{id}/circles", responses=problems(404, 409, 422, 503))
async def get_circles(here: Here, id: Id) -> CircleTestDocument:
    """Say what each joint errs by, by a session that turned one joint at a time."""
    found = await circles_by_session(here.sessions, here.readings, id)
    return circle_document(found, (await here.sessions.setup(id)).cell.robot.name)


@router.get("/{id}/sphere", responses=problems(404, 409, 422, 503))
async def get_sphere(here: Here, id: Id, model_id: ModelIds) -> SphereTestDocument:
    """Say how true the arm holds a ballbar's length to one ball, by a ballbar session, also while it runs.

    Told of are the nominal robot, the models that are asked for, and the one that commanded the arm.
    """
    test, robot = await sphere_of(here, id, model_id)
    return sphere_document(test, robot)


@router.get("/{id}/accuracy", responses=problems(404, 409, 422, 503))
async def get_accuracy(here: Here, id: Id, choice: Chosen) -> AccuracyDocument:
    """Judge a model by the points of a session; of a test of ISO 9283 with its figures."""
    _, found = await accuracy_of(here, await origin_of(here, id), choice)
    return accuracy_document(found.validation, found.test)


@router.get("", responses=listing(422, 503))
async def list_sessions(here: Here, paging: Paged) -> list[SessionReply]:
    """List sessions, oldest first."""
    return paging.shown(await here.sessions.page(paging.page), lambda record: _reply(here, record))


@router.get("/{id}", responses=_READ)
async def get_session(here: Here, id: Id) -> SessionDetailReply:
    """Show a session with its progress and history."""
    shown = await _shown(here, id)
    progress = await here.sessions.progress(id)
    registration = await here.sessions.registration(id)
    return SessionDetailReply.of(
        shown,
        progress=progress,
        states=await here.sessions.states(id),
        skipped_stops=await here.sessions.skipped(id),
        registration=None if registration is None else _registration(registration),
        identities=[identity_reply(taken) for taken in await here.sessions.identities(id)],
        notes=await here.sessions.notes(id),
    )


@router.get("/{id}/plan", responses=problems(404, 409, 422, 503))
async def get_plan(here: Here, id: Id) -> PlanReply:
    """List what the session does, in order."""
    return await asyncio.to_thread(PlanReply.of, await here.sessions.plan(id))


@router.get("/{id}/progress", responses=_READ)
async def get_progress(here: Here, id: Id) -> ProgressReply:
    """Say how far the session is; follow `events` instead of asking again and again."""
    record = await here.sessions.get(id)
    progress = await here.sessions.progress(id)
    if progress is not None:
        return ProgressReply.of(progress)
    return ProgressReply(
        done=0, skipped=0, planned=record.planned, elapsed_s=0.0, remaining_s=None, doing=record.reason
    )


@router.post("/{id}/configurations", status_code=status.HTTP_201_CREATED, responses=_ACT)
async def add_configurations(
    here: Here, id: Id, wanted: AdditionRequest, response: Response, key: OptionalKey
) -> AdditionReply:
    """Add configurations to a session that has not ended, e.g. those that a diagnosis proposes.

    They are judged as planned ones are, and measured after all others once a person has confirmed that the
    cell is clear for them.
    """
    await require_authority(here, id, ActName.SKIP)
    await _check_proposed(here, id, wanted.diagnosis_id)
    found = await here.tracker_sessions.add_stops(id, wanted_stops(wanted), wanted.person, key)
    response.headers["Location"] = f"/api/v1/sessions/{id}/plan"
    return addition_reply(found, await _shown(here, id))


@router.post("/{id}/start", status_code=status.HTTP_202_ACCEPTED, responses=_ACT)
async def start_session(here: Here, id: Id) -> ActionReply:
    """Start a planned session; it asks a person to confirm before anything moves."""
    await require_authority(here, id, ActName.START)
    question = await here.asked_sessions(await here.sessions.get(id)).start(id)
    return await _decided(here, id, f"{question} {here.rack.motion_notice or ''}".strip())


@router.post("/{id}/confirm", status_code=status.HTTP_202_ACCEPTED, responses=_ACT)
async def confirm_session(here: Here, id: Id, by: ConfirmRequest) -> ActionReply:
    """Confirm, as a named person who looked at the cell, what the session asks; then it moves.

    Another tracker than the expected one is accepted only by its serial number; confirmed without it, the
    session asks the tracker again who it is.
    """
    act = _answer(ActName.CONFIRM, by)
    return await _act(here, id, replace(act, accepted_serial=by.accept_serial_number or ""))


@router.post("/{id}/pause", status_code=status.HTTP_202_ACCEPTED, responses=_ACT)
async def pause_session(here: Here, id: Id, by: Anybody = None) -> ActionReply:
    """Ask for a pause; the sentence says when it takes effect, since a motion may have to end first."""
    return await _act(here, id, _halt(ActName.PAUSE, by))


@router.post("/{id}/resume", status_code=status.HTTP_202_ACCEPTED, responses=_ACT)
async def resume_session(here: Here, id: Id, by: AnswerRequest) -> ActionReply:
    """Continue a paused session, as a named person who looked at the cell."""
    return await _act(here, id, _answer(ActName.RESUME, by))


@router.post("/{id}/abort", status_code=status.HTTP_202_ACCEPTED, responses=_ACT)
async def abort_session(here: Here, id: Id, by: Anybody = None) -> ActionReply:
    """Ask for the end; the readings taken so far stay. The sentence says when it takes effect."""
    return await _act(here, id, _halt(ActName.ABORT, by))


def _answer(name: ActName, by: AnswerRequest) -> Act:
    return by.into(Act, name=name, under_way_s=under_way_s(by.pressed_at_s))


async def _check_proposed(here: Context, session_id: int, diagnosis_id: int | None) -> None:
    """Raise NotFoundError for a diagnosis that is not there, ConflictError for one of other readings."""
    if diagnosis_id is not None and (await here.diagnoses.get(diagnosis_id)).session_id != session_id:
        raise ConflictError(
            f"Diagnosis {diagnosis_id} is not of the readings of session {session_id}; name one that is."
        )


async def _shown(here: Context, number: int) -> SessionReply:
    return _reply(here, await here.sessions.get(number))


def _reply(here: Context, record: SessionRecord) -> SessionReply:
    # The record was read a moment ago, and a line is on disk before the runner goes by it.
    runner = here.asked_sessions(record).running(record.id)
    now = None if runner is None else runner.moment
    if now is not None:
        record = replace(record, state=now.state, reason=now.reason)
    foreign = runner.tracker_in_question if isinstance(runner, TrackerRunner) else None
    return SessionReply.of(
        record,
        tracker_in_question=None if foreign is None else identity_reply(foreign),
        question=None if now is None else now.question,
        prompt_id=None if now is None else now.prompt_id,
        trouble=None if now is None else now.trouble,
        motion_notice=here.rack.motion_notice,
    )


def _halt(name: ActName, by: RequestOfPerson | None) -> Act:
    return Act(name, (by.person if by else signed_in_name()) or "")


async def _act(here: Context, number: int, act: Act) -> ActionReply:
    await require_authority(here, number, act.name)
    kind = here.asked_sessions(await here.sessions.get(number))
    return await _decided(here, number, (await kind.act(number, act)).sentence)


async def _decided(here: Context, number: int, sentence: str) -> ActionReply:
    return ActionReply(sentence=sentence, session=await _shown(here, number))


def _registration(found: Registration) -> RegistrationReply:
    rms_mm = found.rms_mm if math.isfinite(found.rms_mm) else None
    return RegistrationReply.of(found, tracker_position_mm=found.translation_mm.tolist(), rms_mm=rms_mm)
