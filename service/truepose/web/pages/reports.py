"""Every kind of report: a list to search, each as a page, and as a PDF behind it."""

import re
from dataclasses import dataclass
from http import HTTPStatus
from itertools import chain
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse, Response

from truepose.domain.errors import TrueposeError, text_of
from truepose.messages.catalogue import Catalogue
from truepose.storage.errors import NotFoundError
from truepose.storage.results.reports import ReportRecord, ReportSubject
from truepose.web.context import Context
from truepose.web.pages.correction import CORRECTION
from truepose.web.pages.diagnosis import DIAGNOSIS
from truepose.web.pages.identification import IDENTIFICATION, VALIDATION
from truepose.web.pages.rendering import Visit, Visited, pdf_response
from truepose.web.pages.report_kinds import ReportKind, ReportRow, report_of
from truepose.web.pages.session_results import Choice, Chosen, origin_of
from truepose.web.pages.sessions import SESSION, kind_of
from truepose.web.problems import status_of
from truepose.web.resources import number_of
from truepose.web.schemas import NUMBER_LIMIT

KINDS: Final[dict[str, ReportKind]] = {
    kind.name: kind for kind in (IDENTIFICATION, VALIDATION, DIAGNOSIS, SESSION, CORRECTION)
}


router = APIRouter(prefix="/reports", include_in_schema=False)
_MONTH: Final = re.compile(r"\d{4}-\d{2}")
_SIMULATED: Final = '<p class="simulated"'  # as the frame of a report says it
Revision = Annotated[
    int | None, Query(ge=1, le=NUMBER_LIMIT, description="Revision of the report; by default, the newest.")
]


@dataclass(frozen=True, slots=True)
class Search:
    """What of the reports is looked for."""

    text: str
    month: str  # 2026-11, or empty


@router.get("", response_class=HTMLResponse)
async def reports_page(visit: Visited, q: str = "", month: str = "") -> HTMLResponse:
    """List the reports, newest first; by robot, name and month."""
    search = Search(q.strip(), month if _MONTH.fullmatch(month) else "")
    found = [await kind.rows(visit.here, search.month) for kind in KINDS.values()]
    rows = sorted(chain.from_iterable(found), key=lambda row: row.recorded_at, reverse=True)
    shown = [row for row in rows if _holds(row, search.text, visit.words)]
    return visit.page("reports/reports.html", place="reports", rows=shown, search=search, any=bool(rows))


@router.get("/{kind}/{id}.pdf")
async def report_pdf(
    visit: Visited, kind: str, id: str, choice: Chosen, revision: Revision = None
) -> Response:
    """Send a report as a PDF."""
    try:
        record = await _record(visit, kind, id, choice, revision)
        name = f"{kind}-{id}-revision-{record.revision}.pdf"
        return await pdf_response(visit, record.page, name)
    except TrueposeError as error:
        return _refused(visit, error)


@router.get("/{kind}/{id}.html")
async def report_file(
    visit: Visited, kind: str, id: str, choice: Chosen, revision: Revision = None
) -> Response:
    """Send a report as the self-contained page that is kept."""
    try:
        record = await _record(visit, kind, id, choice, revision)
    except TrueposeError as error:
        return _refused(visit, error)
    name = f"{kind}-{id}-revision-{record.revision}.html"
    attached = {"Content-Disposition": f'attachment; filename="{name}"'}
    return Response(record.page, media_type="text/html", headers=attached)


@router.get("/{kind}/{id}", response_class=HTMLResponse)
async def report_page(
    visit: Visited, kind: str, id: str, choice: Chosen, revision: Revision = None
) -> HTMLResponse:
    """Show a report, with a button that prints it."""
    from truepose.reports.pages import content_of

    try:
        record = await _record(visit, kind, id, choice, revision)
    except TrueposeError as error:
        return _refused(visit, error)
    revisions = await visit.here.reports.revisions(record.subject)
    return visit.page(
        "reports/report.html",
        place="reports",
        record=record,
        title=KINDS[kind].title,
        simulated=_SIMULATED in record.page,
        content=content_of(record.page),
        revisions=revisions,
        limited=await _is_limited(visit.here, record.subject),
        query=_asked(visit),
    )


async def _is_limited(here: Context, subject: ReportSubject) -> bool:
    """Whether the reader may set a limit for what a report is of."""
    if subject.kind != SESSION.name:
        return False
    kind = kind_of(await origin_of(here, subject.id))
    return kind is not None and kind.limited


async def _record(visit: Visit, kind: str, id: str, choice: Choice, revision: int | None) -> ReportRecord:
    """Return a report; raises TrueposeError."""
    number, found = number_of(id), KINDS.get(kind)
    if number is None or found is None:
        raise NotFoundError("report", number or 0)
    if revision is not None:
        return await visit.here.reports.get(ReportSubject(kind, number), revision, visit.words.tag)
    return await report_of(visit.here, found, number, choice, visit.words)


def _refused(visit: Visit, error: TrueposeError) -> HTMLResponse:
    status = HTTPStatus(status_of(error))
    return visit.page(
        "reports/no_report.html", status, place="reports", why=visit.words.spoken(text_of(error))
    )


def _holds(row: ReportRow, text: str, words: Catalogue) -> bool:
    said = (row.robot, row.serial, words.say(row.title), words.spoken(row.sentence), str(row.id))
    return text.casefold() in " ".join(said).casefold()


def _asked(visit: Visit) -> str:
    """Return what the address chose, for the addresses of the same report in other forms."""
    query = visit.request.url.query
    return f"?{query}" if query else ""
