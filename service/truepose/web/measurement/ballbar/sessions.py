"""Ballbar sessions: plan one, see its steps, press its buttons, read its ledger."""

from dataclasses import replace

from fastapi import Request, Response, status

from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.operation.ballbar.plans import BallbarWish, kit_of
from truepose.operation.ballbar.scene import scene_of
from truepose.operation.ballbar.worker_tasks import plan_task
from truepose.storage.records import RequestKey, SessionSetup
from truepose.web.context import Context, Here
from truepose.web.jobs import planned_or_queued, queued_as_preferred
from truepose.web.measurement.ballbar.replies import ballbar_session_reply, entry_reply, steps_reply
from truepose.web.people.authority import require_authority
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, Later, OptionalKey, RequiredKey, Sender
from truepose.web.requests.presence import while_present
from truepose.web.resources import resource
from truepose.web.schemas.jobs import JobReply
from truepose.web.schemas.measurement.ballbar_requests import (
    ActRequest,
    BallbarSessionRequest,
    act_of,
    wanted_plan,
)
from truepose.web.schemas.measurement.ballbar_scene import SceneReply
from truepose.web.schemas.measurement.ballbar_sessions import (
    ActReply,
    BallbarSessionReply,
    LedgerReply,
    StepsReply,
)

router = resource("/ballbar-sessions", tags=["ballbar sessions"])
_READ = problems(404, 422, 503)
_ACT = problems(400, 404, 409, 413, 415, 422, 503)


@router.post(
    "",
    status_code=status.HTTP_201_CREATED,
    response_model=BallbarSessionReply | JobReply,
    responses=planned_or_queued(BallbarSessionReply, "A worker chooses the poses; the job makes the session.")
    | problems(400, 404, 409, 413, 415, 422, 503),
)
async def plan_ballbar_session(
    here: Here,
    request: Request,
    wanted: BallbarSessionRequest,
    response: Response,
    key: OptionalKey,
    later: Later,
    sender: Sender,
) -> BallbarSessionReply | JobReply:
    """Plan a ballbar session; nothing moves. Where poses are to be chosen this takes up to a minute.

    With `Prefer: respond-async` the choice is a job, and this answers at once (202). Else one plan is made at
    a time and a few wait (503 for further ones). It ends with the connection; with an `Idempotency-Key` it
    goes on for half a minute, in which the same request finds it again.
    """
    setup = SessionSetup(here.cell)
    kit = kit_of(setup)
    if wanted.base_points is not None:
        kit = replace(kit, base_points=wanted.base_points)
    setup = SessionSetup(replace(here.cell, ballbar=kit))
    wish = await _wish(here, wanted)
    if later and wish.given is None:
        number = await queue_plan(here, wanted.name, setup, wish, key, sender)
        return await queued_as_preferred(here, number, response)
    planning = here.ballbar_sessions.plan(wanted.name, setup, wish, key)
    number = await while_present(request, planning)
    response.headers["Location"] = f"/api/v1/ballbar-sessions/{number}"
    return ballbar_session_reply(await here.ballbar_sessions.view(number))


async def queue_plan(
    here: Context, name: str, setup: SessionSetup, wish: BallbarWish, key: RequestKey | None, sender: str
) -> int:
    """Queue the choice of a session's poses and return the job's number."""

    async def check(plan: BallbarPlan) -> str:
        await here.ballbar_sessions.require_possible(setup, plan)
        return ""  # the chooser keeps the ways clear

    return await here.job_desk.plan_checked(name, plan_task(setup, wish), check, key, sender)


async def _wish(here: Context, wanted: BallbarSessionRequest) -> BallbarWish:
    if wanted.plan is None or wanted.plan.model_id is None:
        return wanted_plan(wanted)
    return wanted_plan(wanted, (await here.results.model(wanted.plan.model_id)).model)


@router.get("/{id}", responses=_READ)
async def get_ballbar_session(here: Here, id: Id) -> BallbarSessionReply:
    """Show where a session stands; follow `live` instead of asking again and again."""
    return ballbar_session_reply(await here.ballbar_sessions.view(id))


@router.get("/{id}/steps", responses=_READ)
async def list_steps(here: Here, id: Id) -> StepsReply:
    """List everything that the session does, in order, with what became of it; also before the start."""
    return steps_reply(await here.ballbar_sessions.view(id))


@router.get("/{id}/scene", responses=_READ)
async def get_scene(here: Here, id: Id) -> SceneReply:
    """Show the geometry of the present step: cups, nests, arm, and where the person stands."""
    return SceneReply.of(scene_of(await here.ballbar_sessions.view(id)))


@router.get("/{id}/ledger", responses=listing(404, 422, 503))
async def read_ledger(here: Here, id: Id, paging: Paged) -> LedgerReply:
    """Read what happened, oldest first; `after` is the number of the last entry that is known."""
    found = await here.ballbar_sessions.entries(id, paging.page)
    return LedgerReply(entries=paging.shown(found, entry_reply))


@router.post("/{id}/acts", responses=_ACT)
async def press_button(here: Here, id: Id, wanted: ActRequest, key: RequiredKey) -> ActReply:
    """Press a button. The answer comes when what it did is on disk; a repeated key gets the same answer."""
    await require_authority(here, id, wanted.act)
    answer = await here.ballbar_sessions.act(id, act_of(wanted, key.key), key)
    session = ballbar_session_reply(await here.ballbar_sessions.view(id))
    return ActReply(sentence=answer.sentence, entry=answer.entry, session=session)
