"""A plan on paper: what to prepare, and what to do at each stop, with boxes to tick."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from truepose.domain.ballbar import BallbarPlan, Leg
from truepose.domain.contacts import ContactPlan
from truepose.domain.session import SessionPlan
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, Text, message
from truepose.planning.prediction.plan import PromisedPlan
from truepose.reports.report import Description, Report
from truepose.reports.rounding import format_fixed, with_minus
from truepose.reports.traceability import PageMargins

_TRACKER: Final = ("check.tracker.warm", "check.tracker.nests", "check.tracker.reflector")
_CAMERA: Final = ("check.camera.warm", "check.camera.artefact")
_BALLBAR: Final = ("check.ballbar.calibrator", "check.ballbar.tool", "check.ballbar.ball")
_CONTACTS: Final = ("check.contacts.targets", "check.contacts.zero")
_ALWAYS: Final = ("check.clear", "check.stop")


@dataclass(frozen=True, slots=True)
class CheckStop:
    """One configuration, and what is read in it."""

    config: int
    joints_rad: tuple[float, ...]
    reads: Message
    legs: tuple[Leg, ...] = ()  # of a ballbar, in the order in which they are connected
    placement: int | None = None  # of the base fixture


@dataclass(frozen=True, slots=True)
class Placement:
    """Where the base fixture stands, by its first cup, in the world."""

    number: int
    cup_mm: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Checklist:
    """A plan as a person goes through it."""

    prepare: tuple[str, ...]  # keys of the catalogue
    stops: tuple[CheckStop, ...]
    placements: tuple[Placement, ...] = ()
    base_cups: int = 3


def checklist_of(
    plan: PromisedPlan | SessionPlan | BallbarPlan | ContactPlan, *, camera: bool = False
) -> Checklist:
    """Return what a plan asks for; `camera`: a promised plan's nests are seen by one, not by a tracker."""
    match plan:
        case SessionPlan():
            before = _CAMERA if plan.measures == "poses" else _TRACKER
            return Checklist((*before, *_ALWAYS), tuple(_of_session(plan)))
        case BallbarPlan():
            return _of_ballbar(plan)
        case ContactPlan():
            stops = tuple(CheckStop(one.config, one.joints_rad, _targets(one.targets)) for one in plan.stops)
            return Checklist((*_CONTACTS, *_ALWAYS), stops)
        case _:
            return _of_promise(plan, _CAMERA if camera else _TRACKER)


def _of_session(plan: SessionPlan) -> Iterator[CheckStop]:
    for stop in plan.stops:
        yield CheckStop(stop.config, stop.joints_rad, message("check.nest", nest=stop.nest))


def _of_ballbar(plan: BallbarPlan) -> Checklist:
    stops = tuple(
        CheckStop(pose.config, pose.joints_rad, _legs(pose.legs), pose.legs, placement.number)
        for placement in plan.placements
        for pose in placement.poses
    )
    places = tuple(Placement(one.number, tuple(one.cups_mm[0])) for one in plan.placements)
    return Checklist((*_BALLBAR, *_ALWAYS), stops, places, len(plan.placements[0].cups_mm))


def _of_promise(plan: PromisedPlan, before: tuple[str, ...]) -> Checklist:
    joints = [tuple(map(float, row)) for row in plan.joints_rad]
    numbers = range(plan.measured + 1, plan.total + 1)
    if plan.poses is not None:
        each = zip(numbers, joints, plan.poses.legs, plan.poses.placement, strict=True)
        stops = tuple(CheckStop(n, q, _legs(legs), legs, int(place)) for n, q, legs, place in each)
        places = tuple(
            Placement(one.number, tuple(map(float, one.cups_mm[0]))) for one in plan.poses.fixtures
        )
        return Checklist((*_BALLBAR, *_ALWAYS), stops, places, len(plan.poses.fixtures[0].cups_mm))
    if plan.targets is not None:
        of_targets = zip(numbers, joints, plan.targets, strict=True)
        return Checklist(
            (*_CONTACTS, *_ALWAYS), tuple(CheckStop(n, q, _targets(read)) for n, q, read in of_targets)
        )
    nests = [1] * len(joints) if plan.nest is None else [int(nest) for nest in plan.nest]
    of_nests = zip(numbers, joints, nests, strict=True)
    stops = tuple(CheckStop(n, q, message("check.nest", nest=nest)) for n, q, nest in of_nests)
    return Checklist((*before, *_ALWAYS), stops)


def _legs(legs: Iterable[Leg]) -> Message:
    return message("check.legs", number=len(tuple(legs)))


def _targets(targets: Iterable[int]) -> Message:
    return message("check.targets", targets=", ".join(map(str, targets)))


_WIDTH, _HEIGHT, _EDGE = 360.0, 190.0, 40.0  # of a picture of cups


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


@dataclass(frozen=True, slots=True)
class ChecklistReport(Report):
    """A plan on paper."""

    robot: str
    name: str
    checklist: Checklist
    minutes: float  # of the whole plan
    sentences: tuple[str, ...] = ()  # what the plan promises
    outcome: str = ""  # what it begins with; empty: nothing was predicted of it

    def described(self, words: Catalogue) -> Description:
        """Return what to prepare, the orders of connections, and every stop."""
        checklist = self.checklist
        orders = list(dict.fromkeys(stop.legs for stop in checklist.stops if stop.legs))
        letters = {legs: _letter(number) for number, legs in enumerate(orders)}
        filled_in = {
            "report": self,
            "outcome": self.outcome,
            "checklist": checklist,
            "orders": [_order(letters[legs], legs, checklist.base_cups) for legs in orders],
            "rows": list(_rows(self, letters, words.spoken)),
            "joints": len(checklist.stops[0].joints_rad) if checklist.stops else 0,
        }
        title = words.say("check.title", robot=self.robot)
        imprint = PageMargins(self.robot, self.name)
        return Description(title, self.robot, "checklist.html", filled_in, imprint=imprint)


def _rows(
    report: ChecklistReport, letters: dict[tuple[Leg, ...], str], spoken: Callable[[Text], str]
) -> Iterator[Row]:
    each = report.minutes / max(1, len(report.checklist.stops))
    for place, stop in enumerate(report.checklist.stops):
        joints = tuple(with_minus(format_fixed(math.degrees(angle), 2, "deg")) for angle in stop.joints_rad)
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
