"""The work: everything that was recorded, searched by name, serial number, person and cause."""

from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.effects.registry import EFFECTS
from truepose.storage.leaving.handed_down import HandedDownRepository
from truepose.storage.work.items import WorkKind
from truepose.web.records.links import link_to
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import Catalogue

router = APIRouter(prefix="/work", include_in_schema=False)
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
Searched = Annotated[str, Query(max_length=200, description="Name, serial number, person, cause or number.")]
View = Annotated[str, Query(max_length=20, description="Which kinds of records; empty: all.")]
PageNumber = Annotated[int, Query(ge=1, le=1_000_000, description="Which part of the list.")]


@router.get("", response_class=HTMLResponse)
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
