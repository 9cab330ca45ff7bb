"""Sessions of closed loops: plan one, see its plan and its readings. They are run as all of `/sessions`."""

import asyncio

from fastapi import APIRouter, Response, status

from truepose.analysis.contacts import taken_of
from truepose.sequencing.contacts.dry_run import minutes_of
from truepose.sequencing.contacts.questions import Question, asked
from truepose.storage.records import SessionSetup
from truepose.web.context import Here
from truepose.web.measurement.sessions import get_session
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id, OptionalKey
from truepose.web.schemas.measurement.contact_sessions import (
    ContactPlanReply,
    ContactReadingReply,
    ContactSessionRequest,
    plan_reply,
    wish_of,
)
from truepose.web.schemas.measurement.sessions import SessionDetailReply

router = APIRouter(prefix="/contact-sessions", tags=["sessions of closed loops"])
_READ = problems(404, 422, 503)


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 409, 413, 415, 422, 503))
async def plan_contact_session(
    here: Here, wanted: ContactSessionRequest, response: Response, key: OptionalKey
) -> SessionDetailReply:
    """Plan a session with a probe, gauges, wires or a sensor; its stops are chosen. Nothing moves.

    It is started, confirmed, paused, resumed and aborted at `/sessions/{id}`, where its page is too.
    """
    setup = SessionSetup(here.cell, wanted.attachment)
    number = await here.contact_sessions.plan(wanted.name, setup, wish_of(wanted), key)
    response.headers["Location"] = f"/api/v1/sessions/{number}"
    return await get_session(here, number)


@router.get("/{id}/plan", responses=_READ)
async def get_contact_plan(here: Here, id: Id) -> ContactPlanReply:
    """List what the session asks and does, in order."""
    await here.contact_sessions.get(id)
    plan, cell = await here.sessions.contact_plan(id), (await here.sessions.setup(id)).cell
    minutes = await asyncio.to_thread(minutes_of, plan, cell.robot, cell.base_nominal)
    return plan_reply(plan, [asked(question, plan) for question in Question], minutes)


@router.get("/{id}/readings", responses=_READ)
async def list_contact_readings(here: Here, id: Id) -> list[ContactReadingReply]:
    """List what the gauges read, stop by stop."""
    await here.contact_sessions.get(id)
    lines = await here.session_desk.ledger.whole(id)
    return [ContactReadingReply.of(taken) for taken in taken_of(line.entry for line in lines)]
