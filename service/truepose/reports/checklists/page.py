"""The page of a checklist."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from markupsafe import Markup

from truepose.domain.measurement.ballbar import Leg
from truepose.domain.sentences import Text
from truepose.reports.checklists.checklist import Checklist
from truepose.reports.pages import rendered
from truepose.reports.traceability.imprint import Imprint
from truepose.reports.wording.rounding import fixed, with_minus
from truepose.words.catalogue import ENGLISH, catalogue

_WIDTH, _HEIGHT, _EDGE = 360.0, 190.0, 40.0  # of a picture of cups


@dataclass(frozen=True, slots=True)
class ChecklistInput:
    """What the page is made from."""

    robot: str
    name: str
    checklist: Checklist
    minutes: float  # of the whole plan
    sentences: tuple[str, ...] = ()  # what the plan promises
    simulated: bool = False
    language: str = ENGLISH


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the list."""

    config: int
    reads: str
    legs: tuple[str, ...]  # each with a box of its own
    order: str  # letter of the picture that shows which cups, in which order
    joints_deg: tuple[str, ...]
    minute: str  # when it is due, from the start
    placement: int | None


@dataclass(frozen=True, slots=True)
class Line:
    """A leg in the picture of an order."""

    number: int
    x1: float
    x2: float
    x: float  # of its number
    y: float


@dataclass(frozen=True, slots=True)
class Order:
    """Legs in the order in which they are connected, as a picture."""

    letter: str
    lines: tuple[Line, ...]
    base_x: tuple[float, ...]
    tool_x: tuple[float, ...]


def checklist_page(report: ChecklistInput) -> Markup:
    """Return the checklist as one self-contained page."""
    words, checklist = catalogue(report.language), report.checklist
    orders = list(dict.fromkeys(stop.legs for stop in checklist.stops if stop.legs))
    letters = {legs: _letter(number) for number, legs in enumerate(orders)}
    return rendered(
        "checklist.html",
        words=words,
        say=words.say,
        report=report,
        checklist=checklist,
        imprint=Imprint(report.robot, report.name),
        simulated=report.simulated,
        orders=[_order(letters[legs], legs, checklist.base_cups) for legs in orders],
        rows=list(_rows(report, letters, words.spoken)),
        joints=len(checklist.stops[0].joints_rad) if checklist.stops else 0,
    )


def _rows(
    report: ChecklistInput, letters: dict[tuple[Leg, ...], str], spoken: Callable[[Text], str]
) -> Iterator[Row]:
    each = report.minutes / max(1, len(report.checklist.stops))
    for place, stop in enumerate(report.checklist.stops):
        joints = tuple(with_minus(fixed(math.degrees(angle), 2, "deg")) for angle in stop.joints_rad)
        order, minute = letters.get(stop.legs, ""), f"{place * each:.0f}"
        legs = tuple(f"B{base}-T{tool}" for base, tool in stop.legs)
        yield Row(stop.config, spoken(stop.reads), legs, order, joints, minute, stop.placement)


def _order(letter: str, legs: Iterable[Leg], base_cups: int) -> Order:
    base_x, tool_x = _spread(base_cups), _spread(3)
    lines = tuple(
        _line(number, base_x[base - 1], tool_x[tool - 1]) for number, (base, tool) in enumerate(legs, start=1)
    )
    return Order(letter, lines, base_x, tool_x)


def _line(number: int, x1: float, x2: float) -> Line:
    """Return a leg, with its number nearer to the base the later it comes, where fewer lines cross."""
    share = 0.22 + 0.09 * ((number - 1) % 3)
    y = _HEIGHT - _EDGE - share * (_HEIGHT - 2 * _EDGE)
    return Line(number, x1, x2, x1 + share * (x2 - x1), y)


def _spread(count: int) -> tuple[float, ...]:
    step = (_WIDTH - 2 * _EDGE) / (count - 1)
    return tuple(_EDGE + step * place for place in range(count))


def _letter(number: int) -> str:
    return chr(ord("A") + number % 26) * (number // 26 + 1)
