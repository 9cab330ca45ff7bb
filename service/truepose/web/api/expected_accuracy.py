"""What configurations promise, of the cell and of a session under way."""

import asyncio
from typing import TYPE_CHECKING, Annotated

from fastapi import HTTPException, Query, Request

from truepose.analysis.campaigns.records import measured_session
from truepose.analysis.campaigns.tracker import MeasuredSession
from truepose.domain.cell import Cell
from truepose.exchange.results.plans import PlanDocument, plan_document
from truepose.sessions.tracker.dry_run import minutes_of
from truepose.web.context import Context, Here
from truepose.web.resources import ACT, Id, Name, resource, while_present

if TYPE_CHECKING:
    from truepose.analysis.predicted_accuracy import Promised

router = resource()
Number = Annotated[
    int | None,
    Query(
        ge=1, le=1000, description="Number of configurations to measure; by default, the recommended number."
    ),
]
Limit = Annotated[
    float | None,
    Query(
        alias="limit_mm",
        gt=0,
        le=1000,
        allow_inf_nan=False,
        description="Limit of the largest error, for a predicted pass or fail.",
    ),
]


@router.get("/cells/{name}/plan", tags=["cells"], response_model_exclude_unset=True, responses=ACT)
async def get_promise_of_cell(
    here: Here, request: Request, name: Name, n: Number = None, limit: Limit = None
) -> PlanDocument:
    """Choose configurations and return their predicted accuracy before anything moves; nothing is stored."""
    if name != here.cell.name:
        raise HTTPException(404, f"There is no cell '{name}'; this service has '{here.cell.name}'.")
    return await _document(here, request, here.cell, n, limit)


@router.get("/sessions/{id}/promise", tags=["sessions"], response_model_exclude_unset=True, responses=ACT)
async def get_promise_of_session(
    here: Here, request: Request, id: Id, n: Number = None, limit: Limit = None
) -> PlanDocument:
    """Return the predicted accuracy with the configurations measured so far, and with further ones."""
    session = await measured_session(here.sessions, here.readings, id)
    return await _document(here, request, session, n, limit)


async def _document(
    here: Context, request: Request, of: Cell | MeasuredSession, n: int | None, limit_mm: float | None
) -> PlanDocument:
    promised = await while_present(request, here.promise_desk.promise(of, n))
    return await asyncio.to_thread(document_of, promised, limit_mm)


def document_of(promised: "Promised", limit_mm: float | None = None) -> PlanDocument:
    """Return a promise as a document."""
    from truepose.reports.plans import plan_sentences

    minutes = minutes_for(promised)
    sentences = list(plan_sentences(promised.plan, minutes))
    subject = promised.subject
    return plan_document(
        promised.plan, subject.space.robot.name, minutes, sentences, subject.nominal_mm, limit_mm
    )


def minutes_for(promised: "Promised") -> float:
    """Return how long it takes to measure what is planned [min]."""
    from truepose.planning.prediction.tracker import session_plan

    subject = promised.subject
    return minutes_of(session_plan(promised.plan), subject.space, len(subject.knowns.fixed_nests))
