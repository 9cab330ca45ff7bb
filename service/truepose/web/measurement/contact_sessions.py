"""Sessions of closed loops: plan one, see its plan and its readings. They are run as all of `/sessions`."""

import asyncio

from fastapi import Response, status

from truepose.analysis.campaigns.contacts import taken_of
from truepose.analysis.workers.tasks import ContactPlanTask
from truepose.domain.measurement.contacts import ContactPlan
from truepose.sequencing.contacts.dry_run import minutes_of
from truepose.sequencing.contacts.questions import Question, asked
from truepose.storage.records import RequestKey, SessionSetup
from truepose.web.context import Context, Here
from truepose.web.jobs import planned_or_queued, queued_as_preferred
from truepose.web.measurement.sessions import get_session
from truepose.web.problems import problems
from truepose.web.requests.paging import Counted, listing
from truepose.web.requests.parameters import Id, Later, OptionalKey, Sender
from truepose.web.resources import resource
from truepose.web.schemas.jobs import JobReply
from truepose.web.schemas.measurement.contact_sessions import (
    ContactPlanReply,
    ContactReadingReply,
    ContactSessionRequest,
    plan_reply,
    wish_of,
)
from truepose.web.schemas.measurement.sessions import SessionDetailReply

router = resource("/contact-sessions", tags=["sessions of closed loops"])
_READ = problems(404, 422, 503)


@router.post(
    "",
    status_code=status.HTTP_201_CREATED,
    response_model=SessionDetailReply | JobReply,
    responses=planned_or_queued(SessionDetailReply, "A worker chooses the stops; the job makes the session.")
    | problems(400, 409, 413, 415, 422, 503),
)
async def plan_contact_session(
    here: Here,
    wanted: ContactSessionRequest,
    response: Response,
    key: OptionalKey,
    later: Later,
    sender: Sender,
) -> SessionDetailReply | JobReply:
    """Plan a session with a probe, gauges, wires or a sensor; its stops are chosen. Nothing moves.

    With `Prefer: respond-async` the choice is a job, and this answers at once (202). The session is started,
    confirmed, paused, resumed and aborted at `/sessions/{id}`, where its page is too.
    """
    setup = SessionSetup(here.cell, wanted.attachment)
    if later:
        number = await _queue(here, wanted, setup, key, sender)
        return await queued_as_preferred(here, number, response)
    number = await here.contact_sessions.plan(wanted.name, setup, wish_of(wanted), key)
    response.headers["Location"] = f"/api/v1/sessions/{number}"
    return await get_session(here, number)


async def _queue(
    here: Context, wanted: ContactSessionRequest, setup: SessionSetup, key: RequestKey | None, sender: str
) -> int:
    async def check(plan: ContactPlan) -> str:
        return await here.contact_sessions.what_to_watch(setup, plan)

    task = ContactPlanTask(setup, wish_of(wanted))
    return await here.job_desk.plan_checked(wanted.name, task, check, key, sender)


@router.get("/{id}/plan", responses=_READ)
async def get_contact_plan(here: Here, id: Id) -> ContactPlanReply:
    """List what the session asks and does, in order."""
    await here.contact_sessions.get(id)
    plan, cell = await here.sessions.contact_plan(id), (await here.sessions.setup(id)).cell
    minutes = await asyncio.to_thread(minutes_of, plan, cell.robot, cell.base_nominal)
    return plan_reply(plan, [asked(question, plan) for question in Question], minutes)


@router.get("/{id}/readings", responses=listing(404, 422, 503))
async def list_contact_readings(here: Here, id: Id, paging: Counted) -> list[ContactReadingReply]:
    """List what the gauges read, stop by stop."""
    await here.contact_sessions.get(id)
    lines = await here.session_desk.ledger.whole(id)
    return paging.of(taken_of(line.entry for line in lines), ContactReadingReply.of)
