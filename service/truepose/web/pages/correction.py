"""Corrections: a form that takes a program, what each file came to, and the report of it."""

import asyncio
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.analysis.job_queue.file_tasks import MOST_TARGETS
from truepose.kinematics.inverse import BRANCH_NAMES
from truepose.messages.catalogue import Catalogue
from truepose.storage.records import CorrectionRecord
from truepose.storage.results.items import WorkKind
from truepose.web.api.corrections import ANGLES, corrected_name
from truepose.web.context import Context
from truepose.web.pages.records import record_at, trail_of
from truepose.web.pages.rendering import Visited
from truepose.web.pages.report_kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.pages.session_results import Choice
from truepose.web.resources import WantedModel
from truepose.web.schemas import NUMBER_LIMIT

if TYPE_CHECKING:
    from truepose.reports.correction import CorrectionReport
    from truepose.reports.traceability import ReportConditions


router = APIRouter(prefix="/corrections", include_in_schema=False)
_SHOWN: Final = 50
_ROWS: Final = 200
After = Annotated[int, Query(ge=0, le=NUMBER_LIMIT, description="Only targets after this one.")]


@router.get("", response_class=HTMLResponse)
async def corrections_page(visit: Visited, wanted: WantedModel = None) -> HTMLResponse:
    """Show the form that takes a program, and the latest corrections."""
    return visit.page(
        "results/corrections.html",
        models=await visit.here.results.newest_models(_SHOWN),
        wanted=wanted,
        branches=BRANCH_NAMES,
        angles=ANGLES,
        most=MOST_TARGETS,
        records=await visit.here.corrections.newest(_SHOWN),
        shown=_SHOWN,
    )


@router.get("/{id}", response_class=HTMLResponse)
async def correction_page(visit: Visited, id: str, after: After = 0) -> HTMLResponse:
    """Show what a file came to, with its targets."""
    record = await record_at(id, visit.here.corrections.get)
    from truepose.reports.correction import correction_sentences

    report = await _report(visit.here, record, visit.words)
    shown = replace(report, conditions=_conditions(record), first=after, most=_ROWS)
    return visit.page(
        "results/correction.html",
        record=record,
        sentence=visit.words.spoken(next(correction_sentences(record.correction.totals))),
        content=await asyncio.to_thread(shown.content),
        saved_as=corrected_name(record.name),
        trail=await trail_of(visit, WorkKind.CORRECTION, record.id),
    )


async def _report(here: Context, record: CorrectionRecord, words: Catalogue) -> "CorrectionReport":
    from truepose.reports.correction import CorrectionReport

    return CorrectionReport(
        record.name,
        record.robot,
        record.correction,
        await here.corrections.targets(record.id),
        (record.original_sha256, record.corrected_sha256),
        language=words.tag,
    )


async def _rows(here: Context, month: str) -> list[ReportRow]:
    records = await here.corrections.newest_of(LISTED, month)
    return [CORRECTION.row(one, one.robot, one.name) for one in records]


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    record = await here.corrections.get(number)
    report = await _report(here, record, words)

    async def conditions(_: Catalogue) -> "ReportConditions":
        return _conditions(record)

    return Drawable((number, *report.hashes), conditions, lambda whole: replace(report, conditions=whole))


def _conditions(record: CorrectionRecord) -> "ReportConditions":
    from truepose.reports.traceability import ReportConditions

    return ReportConditions(simulated=record.simulated)


CORRECTION = ReportKind("correction", "reports.correction", _rows, _drawable)
