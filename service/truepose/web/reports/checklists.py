"""The checklist of a session, or of what a plan promises before one: on the screen and to print."""

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.cell.description import Cell
from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.domain.measurement.contacts import ContactPlan
from truepose.domain.measurement.session import SessionPlan
from truepose.storage.records import SessionRecord
from truepose.web.context import Context
from truepose.web.measurement.promises import Number, minutes_for
from truepose.web.requests.parameters import Id
from truepose.web.requests.presence import while_present
from truepose.web.visiting.drawn import printed
from truepose.web.visiting.visits import Visit, Visited
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.checklists.page import ChecklistInput

router = APIRouter(include_in_schema=False)
_SECONDS_PER_MINUTE = 60.0


@router.get("/sessions/{id}/checklist", response_class=HTMLResponse)
async def checklist_view(visit: Visited, id: Id) -> HTMLResponse:
    """Show what a session asks for, stop by stop."""
    record, asked = await visit.here.sessions.get(id), await _asked(visit.here, id, visit.words)
    return await _shown(visit, asked, f"/sessions/{id}/checklist.pdf", record=record)


@router.get("/sessions/{id}/checklist.pdf")
async def checklist_pdf(visit: Visited, id: Id) -> Response:
    """Send the same as a PDF."""
    return await _printed(visit, await _asked(visit.here, id, visit.words), f"checklist-{id}")


@router.get("/plan/checklist", response_class=HTMLResponse)
async def plan_checklist_view(visit: Visited, n: Number = None) -> HTMLResponse:
    """Show what a plan of n configurations asks for, before there is a session."""
    asked = await _promised(visit, n)
    number = len(asked.checklist.stops)
    to_print = f"/plan/checklist.pdf?n={number}"
    return await _shown(visit, asked, to_print, record=None, planned=number)


@router.get("/plan/checklist.pdf")
async def plan_checklist_pdf(visit: Visited, n: Number = None) -> Response:
    """Send the same as a PDF."""
    return await _printed(visit, await _promised(visit, n), "checklist-of-a-plan")


async def _shown(
    visit: Visit, asked: "ChecklistInput", to_print: str, *, record: SessionRecord | None, planned: int = 0
) -> HTMLResponse:
    from truepose.reports.checklists.page import checklist_page
    from truepose.reports.pages import content_of

    content = content_of(await asyncio.to_thread(checklist_page, asked))
    return visit.page(
        "reports/checklist_view.html",
        content=content,
        name=asked.name,
        to_print=to_print,
        record=record,
        planned=planned,
    )


async def _printed(visit: Visit, asked: "ChecklistInput", name: str) -> Response:
    from truepose.reports.checklists.page import checklist_page

    page = await asyncio.to_thread(checklist_page, asked)
    return await printed(visit, str(page), f"{name}.pdf")


async def _promised(visit: Visit, n: int | None) -> "ChecklistInput":
    from truepose.reports.checklists.checklist import checklist_of
    from truepose.reports.checklists.page import ChecklistInput

    here, words = visit.here, visit.words
    promised = await while_present(visit.request, here.promise_desk.promise(here.cell, n))
    return ChecklistInput(
        here.cell.robot.name,
        words.say("page.plan"),
        checklist_of(promised.plan),
        await asyncio.to_thread(minutes_for, promised),
        simulated=here.simulated,
        language=words.tag,
    )


async def _asked(here: Context, number: int, words: Catalogue) -> "ChecklistInput":
    from truepose.reports.checklists.checklist import checklist_of
    from truepose.reports.checklists.page import ChecklistInput

    record, setup = await here.sessions.get(number), await here.sessions.setup(number)
    plan = await _plan(here, record.role, number)
    minutes = await asyncio.to_thread(_minutes, plan, setup.cell)
    name = words.between.join((record.name, words.say("page.the_session", number=number)))
    return ChecklistInput(
        setup.cell.robot.name,
        name,
        checklist_of(plan),
        minutes,
        simulated=setup.simulated,
        language=words.tag,
    )


async def _plan(here: Context, role: str, number: int) -> SessionPlan | BallbarPlan | ContactPlan:
    if role == "ballbar":
        return await here.sessions.ballbar_plan(number)
    if role == "contacts":
        return await here.sessions.contact_plan(number)
    return await here.sessions.plan(number)


def _minutes(plan: SessionPlan | BallbarPlan | ContactPlan, cell: Cell) -> float:
    """Return how long a plan takes by its dry run."""
    from truepose.sequencing.ballbar.plan.dry_run import dry_run as ballbar_run
    from truepose.sequencing.contacts.dry_run import minutes_of
    from truepose.sequencing.tracker.plan.dry_run import dry_run

    match plan:
        case BallbarPlan():
            return ballbar_run(plan, cell.ballbar or BallbarKit()).duration_s / _SECONDS_PER_MINUTE
        case ContactPlan():
            return minutes_of(plan, cell.robot, cell.base_nominal)
        case _:
            run = dry_run(plan, cell.robot, cell.base_nominal, cell.nests, len(cell.fixed_nests))
            return run.duration_s / _SECONDS_PER_MINUTE
