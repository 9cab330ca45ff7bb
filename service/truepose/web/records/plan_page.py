"""What a plan promises, for people: sentences, the curve, the table behind it."""

import asyncio
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.storage.documents import to_document
from truepose.web.measurement.promises import Number, minutes_for
from truepose.web.visiting.drawn import Whole, drawn_part
from truepose.web.visiting.rendering import rendered
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.analysis.promises import Promised

router = APIRouter(include_in_schema=False)


@dataclass(frozen=True, slots=True)
class Shown:
    """What the page shows of a plan."""

    n: int
    sentences: tuple[str, ...]
    figure: Markup
    head: tuple[str, ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]  # number of configurations, cells of the table


@router.get("/plan", response_class=HTMLResponse)
async def plan_page(visit: Visited, n: Number = None, whole: Whole = False) -> HTMLResponse:
    """Show what n configurations promise in this cell."""
    cell, plans = visit.here.cell, visit.may("plan_session")

    async def draw() -> str:
        promised = await visit.here.promise_desk.promise(cell, n)
        return await asyncio.to_thread(_told, promised, visit.words, plans=plans)

    told = await drawn_part(visit, f"plan {n} {plans} {json.dumps(to_document(cell))}", draw, whole=whole)
    return visit.page("sessions/plan.html", told=told, n=n)


def _told(promised: "Promised", words: Catalogue, *, plans: bool) -> str:
    shown = _shown(promised, words)
    return rendered("sessions/plan_told.html", shown=shown, plans=plans, words=words, say=words.say)


def _shown(promised: "Promised", words: Catalogue) -> Shown:
    from truepose.reports.figures.curves.promise import promise_curve
    from truepose.reports.plans import curve_head, curve_rows, plan_sentences

    plan = promised.plan
    sentences = map(words.spoken, plan_sentences(plan, minutes_for(promised)))
    rows = zip((point.n for point in plan.curve), curve_rows(plan), strict=True)
    figure = promise_curve(plan, words)
    return Shown(plan.total, tuple(sentences), figure, curve_head(words), tuple(rows))
