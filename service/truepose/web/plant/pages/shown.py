"""Results and cells as the pages of a plant show them: with the page that the cell itself has."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from truepose.storage.plant.looking import ResultKind, ResultSeen
from truepose.storage.plant.newest import ToldSeen
from truepose.storage.plant.records import VisitRecord
from truepose.web.plant.context import PlantContext

_PAGES: Final = {
    "campaign": "campaigns",
    "identification": "identifications",
    "diagnosis": "diagnoses",
    "validation": "validations",
    "model": "models",
    "correction": "corrections",
}
_TITLES: Final[Mapping[ResultKind, str]] = {
    "campaign": "work.campaign",
    "identification": "work.identification",
    "diagnosis": "work.diagnosis",
    "validation": "work.validation",
    "model": "work.model",
    "correction": "work.correction",
    "report": "plant.report",
    "closing": "plant.closing",
}


@dataclass(frozen=True, slots=True)
class ShownResult:
    """A result, and where the cell shows it."""

    seen: ResultSeen
    title: str  # a key of the catalogue
    href: str  # empty: the cell has no page of it, or is none of the plant's any more


@dataclass(frozen=True, slots=True)
class ShownCell:
    """A cell, and the newest visit to it."""

    name: str
    url: str  # empty: it stands in the cells file no more
    newest: VisitRecord | None


@dataclass(frozen=True, slots=True)
class Places:
    """Where the cells of a plant show what they have."""

    urls: Mapping[str, str]  # by cell
    branches: Mapping[str, int]  # that a cell's own numbers are those of

    def of(self, seen: ResultSeen | ToldSeen) -> str:
        """Return where a cell shows a result; on another chain its number may be that of another record."""
        known = seen.cell in self.urls and self.branches.get(seen.cell) == seen.branch_id
        if not known or seen.kind not in _PAGES:
            return ""
        return f"{self.urls[seen.cell]}/{_PAGES[seen.kind]}/{seen.record_id}"


async def places_of(here: PlantContext) -> Places:
    """Return where the cells show what they have, as it is now."""
    return Places(_urls(here), await here.overview.newest_branches())


def shown_results(results: Iterable[ResultSeen], places: Places) -> list[ShownResult]:
    """Return results with their titles and places."""
    return [ShownResult(seen, _TITLES[seen.kind], places.of(seen)) for seen in results]


def shown_cells(here: PlantContext, visits: Mapping[str, VisitRecord | None]) -> list[ShownCell]:
    """Return every cell with its newest visit."""
    urls = _urls(here)
    return [ShownCell(name, urls.get(name, ""), newest) for name, newest in visits.items()]


def _urls(here: PlantContext) -> dict[str, str]:
    return {cell.name: cell.url for cell in here.collector.cells}
