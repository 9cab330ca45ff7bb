"""What a plan promises: sentences, curve and table; and checklists, on the screen and to print."""

import asyncio
import json
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.cell import BallbarKit, Cell
from truepose.domain.contacts import ContactPlan
from truepose.domain.session import SessionPlan
from truepose.messages.catalogue import Catalogue
from truepose.storage.documents import to_document
from truepose.storage.records import SessionRecord
from truepose.web.api.expected_accuracy import Limit, Number, minutes_for
from truepose.web.context import Context
from truepose.web.pages.rendering import Visit, Visited, Whole, pdf_response, render, render_part
from truepose.web.resources import Id, while_present

if TYPE_CHECKING:
    from truepose.analysis.predicted_accuracy import Promised
    from truepose.reports.checklist import ChecklistReport


router = APIRouter(include_in_schema=False)


@router.get("/plan", response_class=HTMLResponse)
async def plan_page(
    visit: Visited, n: Number = None, limit: Limit = None, whole: Whole = False
) -> HTMLResponse:
    """Show what n configurations promise in this cell."""
    cell, plans = visit.here.cell, visit.may("plan_session")

    async def draw() -> str:
        promised = await visit.here.promise_desk.promise(cell, n)
        return await asyncio.to_thread(_rendered, promised, limit, visit.words, plans=plans)

    # The button that plans is in the drawn part, so it is kept for each kind of visitor (commit e3ad9c17).
    of = f"plan {n} {limit} {plans} {json.dumps(to_document(cell))}"
    told = await render_part(visit, of, draw, whole=whole)
    return visit.page("sessions/plan.html", told=told, n=n, limit=limit)


def _rendered(promised: "Promised", limit_mm: float | None, words: Catalogue, *, plans: bool) -> str:
    from truepose.planning.prediction.outcome import plan_outcome
    from truepose.reports.figures.curves import promise_curve
    from truepose.reports.plans import curve_table, plan_sentences

    plan = promised.plan
    return render(
        "sessions/plan_told.html",
        outcome=words.spoken(plan_outcome(plan, promised.subject.nominal_mm, limit_mm)),
        limit=limit_mm,
        n=plan.total,
        sentences=[*map(words.spoken, plan_sentences(plan, minutes_for(promised)))],
        figure=promise_curve(plan, words),
        curve=curve_table(plan, words),
        numbers=[point.n for point in plan.curve],
        plans=plans,
        words=words,
        say=words.say,
    )


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
async def plan_checklist_view(visit: Visited, n: Number = None, limit: Limit = None) -> HTMLResponse:
    """Show what a plan of n configurations asks for, before there is a session."""
    asked = await _promised(visit, n, limit)
    number = len(asked.checklist.stops)
    to_print = f"/plan/checklist.pdf?n={number}" + ("" if limit is None else f"&limit_mm={limit!r}")
    return await _shown(visit, asked, to_print, record=None, planned=number)


@router.get("/plan/checklist.pdf")
async def plan_checklist_pdf(visit: Visited, n: Number = None, limit: Limit = None) -> Response:
    """Send the same as a PDF."""
    return await _printed(visit, await _promised(visit, n, limit), "checklist-of-a-plan")


async def _shown(
    visit: Visit, asked: "ChecklistReport", to_print: str, *, record: SessionRecord | None, planned: int = 0
) -> HTMLResponse:
    content = await asyncio.to_thread(asked.content)
    return visit.page(
        "reports/checklist_view.html",
        content=content,
        name=asked.name,
        to_print=to_print,
        record=record,
        planned=planned,
    )


async def _printed(visit: Visit, asked: "ChecklistReport", name: str) -> Response:
    page = await asyncio.to_thread(asked.page)
    return await pdf_response(visit, str(page), f"{name}.pdf")


async def _promised(visit: Visit, n: int | None, limit_mm: float | None) -> "ChecklistReport":
    from truepose.planning.prediction.outcome import plan_outcome
    from truepose.reports.checklist import ChecklistReport, checklist_of
    from truepose.reports.traceability import ReportConditions

    here, words = visit.here, visit.words
    promised = await while_present(visit.request, here.promise_desk.promise(here.cell, n))
    return ChecklistReport(
        here.cell.robot.name,
        words.say("page.plan"),
        checklist_of(promised.plan, camera=here.cell.camera is not None),
        await asyncio.to_thread(minutes_for, promised),
        outcome=words.spoken(plan_outcome(promised.plan, promised.subject.nominal_mm, limit_mm)),
        conditions=ReportConditions(simulated=here.simulated),
        language=words.tag,
    )


async def _asked(here: Context, number: int, words: Catalogue) -> "ChecklistReport":
    from truepose.reports.checklist import ChecklistReport, checklist_of
    from truepose.reports.traceability import ReportConditions

    record, setup = await here.sessions.get(number), await here.sessions.setup(number)
    plan = await here.session_desk.kind_of(record).stored_plan(number)
    minutes = await asyncio.to_thread(_minutes, plan, setup.cell)
    name = words.between.join((record.name, words.say("page.the_session", number=number)))
    return ChecklistReport(
        setup.cell.robot.name,
        name,
        checklist_of(plan),
        minutes,
        conditions=ReportConditions(simulated=setup.simulated),
        language=words.tag,
    )


def _minutes(plan: SessionPlan | BallbarPlan | ContactPlan, cell: Cell) -> float:
    """Return how long a plan takes by its dry run."""
    from truepose.sessions.ballbar.dry_run import dry_run as ballbar_run
    from truepose.sessions.contact.dry_run import minutes_of
    from truepose.sessions.tracker.dry_run import dry_run

    match plan:
        case BallbarPlan():
            return ballbar_run(plan, cell.ballbar or BallbarKit()).duration_s / _SECONDS_PER_MINUTE
        case ContactPlan():
            return minutes_of(plan, cell.robot, cell.base_nominal)
        case _:
            run = dry_run(plan, cell.robot, cell.base_nominal, cell.nests, len(cell.fixed_nests))
            return run.duration_s / _SECONDS_PER_MINUTE
