"""What a plan promises, for people: sentences, the curve, the table behind it."""

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.web.measurement.promises import Number, minutes_for
from truepose.web.requests.presence import while_present
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
async def plan_page(visit: Visited, n: Number = None) -> HTMLResponse:
    """Show what n configurations promise in this cell."""
    promising = visit.here.promise_desk.promise(visit.here.cell, n)
    promised = await while_present(visit.request, promising)
    shown = await asyncio.to_thread(_shown, promised, visit.words)
    return visit.page("plan.html", shown=shown)


def _shown(promised: "Promised", words: Catalogue) -> Shown:
    from truepose.reports.figures.promise_curve import promise_curve
    from truepose.reports.plans import curve_head, curve_rows, plan_sentences

    plan = promised.plan
    sentences = map(words.spoken, plan_sentences(plan, minutes_for(promised)))
    rows = zip((point.n for point in plan.curve), curve_rows(plan), strict=True)
    figure = promise_curve(plan, words)
    return Shown(plan.total, tuple(sentences), figure, curve_head(words), tuple(rows))
