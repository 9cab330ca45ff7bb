"""The map of a diagnosis: at which places something was found or described, over which variables."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from truepose.domain.results.diagnosis import Diagnosis, Finding, Worth
from truepose.effects.cells import place_of

Place = tuple[str, str]  # where, over what

# From the instrument along the arm to the tool; then from the arm's own variables to those around it.
_PLACES = ("tracker", "ballbar", "placement", "base", "joint", "link", "flange", "tool", "nest")
_VARIABLES = (
    "angle",
    "torque",
    "load",
    "direction",
    "last move",
    "place",
    "azimuth",
    "elevation",
    "range",
    "time",
    "temperature",
    "mounting",
    "constant",
)


@dataclass(frozen=True, slots=True)
class MapCell:
    """A place and a variable, and what is told there."""

    where: str
    over: str
    share: float  # of the sum of squares of all that is told; 0 where only a rival of a finding would act
    findings: tuple[int, ...]  # their numbers on the page
    rival_of: tuple[int, ...]

    @property
    def place(self) -> Place:
        """Its row and its column."""
        return self.where, self.over


@dataclass(frozen=True, slots=True)
class CauseMap:
    """Places as rows, variables as columns, and the cells where something is."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    cells: tuple[MapCell, ...]  # row by row
    links: tuple[tuple[Place, Place], ...]  # a finding and where its rival would act


def cause_map(diagnosis: Diagnosis) -> CauseMap | None:
    """Return the map; None where there are fewer than two cells to compare."""
    told = dict(_told(diagnosis))
    links = tuple(dict.fromkeys(_links(diagnosis)))
    places = dict.fromkeys((*told, *(rival for _, rival in links)))
    if len(places) < 2:
        return None
    numbers = _numbers(diagnosis)
    total = sum(told.values()) or 1.0
    cells = tuple(
        MapCell(
            *place,
            share=told.get(place, 0.0) / total,
            findings=numbers.get(place, ()),
            rival_of=tuple(sorted({n for own, rival in links if rival == place for n in numbers[own]})),
        )
        for place in sorted(
            places, key=lambda place: (_order(place[0], _PLACES), _order(place[1], _VARIABLES))
        )
    )
    columns = sorted({cell.over for cell in cells}, key=lambda over: _order(over, _VARIABLES))
    return CauseMap(tuple(dict.fromkeys(cell.where for cell in cells)), tuple(columns), cells, links)


def _told(diagnosis: Diagnosis) -> Iterator[tuple[Place, float]]:
    """Yield every place with the mean square of what is told there [mm2]."""
    squares: defaultdict[Place, float] = defaultdict(float)
    for finding in _placed(diagnosis):
        squares[finding.where, finding.over] += _square(finding.worth)
    for entry in diagnosis.remaining.described:
        squares[entry.where, entry.over] += _square(entry.worth)
    yield from squares.items()


def _square(worth: Worth | None) -> float:
    if worth is None:
        return 0.0
    return (worth.mean_mm if worth.own_mm is None else worth.own_mm) ** 2


def _placed(diagnosis: Diagnosis) -> list[Finding]:
    """Return the findings that move the tool and say where they act."""
    return [finding for finding in diagnosis.all_findings if finding.where and finding.worth is not None]


def _numbers(diagnosis: Diagnosis) -> dict[Place, tuple[int, ...]]:
    placed = _placed(diagnosis)
    numbers: dict[Place, tuple[int, ...]] = {}
    for number, finding in enumerate(diagnosis.all_findings, 1):
        if finding in placed:
            place = finding.where, finding.over
            numbers[place] = (*numbers.get(place, ()), number)
    return numbers


def _links(diagnosis: Diagnosis) -> Iterator[tuple[Place, Place]]:
    """Yield where the rivals of findings would act instead; those of small ones would hide the others."""
    placed = _placed(diagnosis)
    for finding in diagnosis.findings:
        own = finding.where, finding.over
        rivals = map(place_of, finding.confusable_with) if finding in placed else ()
        yield from ((own, rival) for rival in rivals if rival is not None and rival != own)


def _order(name: str, known: tuple[str, ...]) -> tuple[int, list[int], str]:
    """Return a key that puts names in the order of the trade, joint 10 after joint 9."""
    rank = next((k for k, start in enumerate(known) if name.startswith(start)), len(known))
    return rank, [int(number) for number in re.findall(r"\d+", name)], name
