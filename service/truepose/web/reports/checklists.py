"""The checklist of a planned session, on the screen and to print."""

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from truepose.domain.artefacts import BallbarKit
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.cell import Cell
from truepose.domain.contacts import ContactPlan
from truepose.domain.session import SessionPlan
from truepose.web.context import Context
from truepose.web.requests.parameters import Id
from truepose.web.visiting.drawn import printed
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.checklists.page import ChecklistInput

router = APIRouter(include_in_schema=False)
_SECONDS_PER_MINUTE = 60.0


@router.get("/sessions/{id}/checklist", response_class=HTMLResponse)
async def checklist_view(visit: Visited, id: Id) -> HTMLResponse:
    """Show what a session asks for, stop by stop."""
    from truepose.reports.checklists.page import checklist_page
    from truepose.reports.pages import content_of

    record, asked = await visit.here.sessions.get(id), await _asked(visit.here, id, visit.words)
    content = content_of(await asyncio.to_thread(checklist_page, asked))
    return visit.page("checklist_view.html", record=record, content=content)


@router.get("/sessions/{id}/checklist.pdf")
async def checklist_pdf(visit: Visited, id: Id) -> Response:
    """Send the same as a PDF."""
    from truepose.reports.checklists.page import checklist_page

    page = await asyncio.to_thread(checklist_page, await _asked(visit.here, id, visit.words))
    return await printed(visit, str(page), f"checklist-{id}.pdf")


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
    from truepose.sequencing.tracker.dry_run import dry_run

    match plan:
        case BallbarPlan():
            return ballbar_run(plan, cell.ballbar or BallbarKit()).duration_s / _SECONDS_PER_MINUTE
        case ContactPlan():
            return minutes_of(plan, cell.robot, cell.base_nominal)
        case _:
            run = dry_run(plan, cell.robot, cell.base_nominal, cell.nests, len(cell.fixed_nests))
            return run.duration_s / _SECONDS_PER_MINUTE
