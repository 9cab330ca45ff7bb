"""How a record came about, what came of it, and what to do next: the same on every page of a record."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from http import HTTPStatus
from typing import Final, TypeVar

from fastapi.responses import HTMLResponse

from truepose.storage.errors import NotFoundError
from truepose.storage.work.items import WorkKind
from truepose.web.places.next_step import Step, step_after
from truepose.web.records.links import Link, address_of, link_to
from truepose.web.requests.parameters import number_of
from truepose.web.visiting.visits import Visit

Record = TypeVar("Record")
_REPORTED: Final = (WorkKind.IDENTIFICATION, WorkKind.DIAGNOSIS, WorkKind.VALIDATION)


@dataclass(frozen=True, slots=True)
class Trail:
    """A record among its own."""

    here: str  # address of the record itself
    report: str  # its address; empty where a record of this kind has none
    links: tuple[Link, ...]
    step: Step | None


async def trail_of(visit: Visit, kind: WorkKind, number: int) -> Trail:
    """Return a record's trail; the record must exist."""
    lineage = await visit.here.lineages.of(kind, number)
    links = tuple(link_to(item, visit.words) for item in lineage.items)
    report = f"/reports/{kind.value}/{number}" if kind in _REPORTED else ""
    return Trail(address_of(kind, number), report, links, step_after(lineage))


async def record_at(id: str, get: Callable[[int], Awaitable[Record]]) -> Record | None:
    """Return the record of a number in an address; None where it names none."""
    number = number_of(id)
    if number is None:
        return None
    try:
        return await get(number)
    except NotFoundError:
        return None


def missing(visit: Visit) -> HTMLResponse:
    """Return the page of an address that names no record."""
    return visit.page("errors/missing.html", HTTPStatus.NOT_FOUND)
