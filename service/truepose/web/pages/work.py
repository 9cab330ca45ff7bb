"""The work: everything that was recorded, searched by name, serial number, person and cause; and each job."""

from typing import Annotated, Final

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, RedirectResponse

from truepose.effects.registry import EFFECTS
from truepose.messages.catalogue import Catalogue
from truepose.messages.error_codes import explain
from truepose.storage.plant.deployments import HandedDownRepository
from truepose.storage.records import JobRecord
from truepose.storage.results.items import WorkKind
from truepose.web.pages.records import MAKES, address_of, link_to, record_at, state_look, title_of
from truepose.web.pages.rendering import Visit, Visited

router = APIRouter(include_in_schema=False)
_ROWS: Final = 50
_RESULTS: Final = (
    WorkKind.IDENTIFICATION,
    WorkKind.DIAGNOSIS,
    WorkKind.MODEL,
    WorkKind.VALIDATION,
    WorkKind.CORRECTION,
)
_VIEWS: Final = {
    "": tuple(WorkKind),
    "sessions": (WorkKind.SESSION,),
    "campaigns": (WorkKind.CAMPAIGN,),
    "results": _RESULTS,
    "jobs": (WorkKind.JOB,),
}
ROBOTS: Final = "robots"
# Nouns that people type as an address, and what this cell has of them.
NOUNS: Final = {
    "/robots": "/work?kind=robots",
    "/fleet": "/work?kind=robots",
    "/campaigns": "/work?kind=campaigns",
    "/readings": "/work?kind=campaigns",
    "/instruments": "/",
}
Searched = Annotated[
    str,
    Query(max_length=200, description="Text to find: name, serial number, person, cause or record number."),
]
View = Annotated[str, Query(max_length=20, description="Kinds of records; empty for all.")]
PageNumber = Annotated[int, Query(ge=1, le=1_000_000, description="Page of the list.")]


async def noun_page(request: Request) -> RedirectResponse:
    """Lead from the noun in an address to the page that lists it."""
    return RedirectResponse(NOUNS[request.url.path])


for _noun in NOUNS:
    router.add_api_route(_noun, noun_page, methods=["GET"], response_class=RedirectResponse)


@router.get("/work", response_class=HTMLResponse)
async def work_page(visit: Visited, q: Searched = "", kind: View = "", page: PageNumber = 1) -> HTMLResponse:
    """List what was recorded, newest first, or the robots of which something was."""
    work, words = visit.here.work, visit.words
    handed_down = await HandedDownRepository(visit.here.database).newest(1)
    if kind == ROBOTS:
        robots = await work.robots()
        return visit.page("work.html", q="", kind=kind, robots=robots, handed_down=handed_down)
    kinds = _VIEWS.get(kind, _VIEWS[""])
    found = await work.page(kinds, _texts(q.strip(), words), skip=(page - 1) * _ROWS, limit=_ROWS)
    return visit.page(
        "work.html",
        q=q,
        kind=kind if kind in _VIEWS else "",
        robots=None,
        handed_down=handed_down,
        links=[link_to(item, words) for item in found.items],
        total=found.total,
        part=page,
        parts_of_list=max(1, -(-found.total // _ROWS)),
    )


def _texts(asked: str, words: Catalogue) -> tuple[str, ...]:
    """Return what records are searched for: what was asked, and the names of causes that are called so."""
    if not asked:
        return ()
    called = asked.casefold()
    return asked, *(name for name in EFFECTS if called in words.effect(name).casefold())


@router.get("/jobs/{id}", response_class=HTMLResponse)
async def job_page(visit: Visited, id: str) -> HTMLResponse:
    """Show a job; the page follows it and goes to what it made."""
    record = await record_at(id, visit.here.jobs.get)
    return _shown(visit, record)


def _shown(visit: Visit, record: JobRecord) -> HTMLResponse:
    made, title = MAKES[record.kind]
    look, state = state_look(WorkKind.JOB, record.state)
    sources = [(WorkKind.CAMPAIGN, "campaign_id"), (WorkKind.MODEL, "model_id")]
    asked = [(kind, record.request.get(key)) for kind, key in sources]
    return visit.page(
        "results/job.html",
        record=record,
        title=title,
        look=look,
        state=state,
        made=None if record.result_id is None else address_of(made, record.result_id),
        told=None if record.code is None else explain(record.code, visit.words),
        sources=[(address_of(kind, n), title_of(kind, n, visit.words)) for kind, n in asked if n],
    )
