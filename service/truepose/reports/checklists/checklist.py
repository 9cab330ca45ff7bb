"""What a plan asks of the person at the cell, stop by stop, whatever the instrument."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from truepose.domain.measurement.ballbar import BallbarPlan, Leg
from truepose.domain.measurement.contacts import ContactPlan
from truepose.domain.measurement.session import SessionPlan
from truepose.domain.sentences import Sentence, said
from truepose.planning.promise.plan import PromisedPlan

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
    reads: Sentence
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


def checklist_of(plan: PromisedPlan | SessionPlan | BallbarPlan | ContactPlan) -> Checklist:
    """Return what a plan asks for."""
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
            return _of_promise(plan)


def _of_session(plan: SessionPlan) -> Iterator[CheckStop]:
    for stop in plan.stops:
        yield CheckStop(stop.config, stop.joints_rad, said("check.nest", nest=stop.nest))


def _of_ballbar(plan: BallbarPlan) -> Checklist:
    stops = tuple(
        CheckStop(pose.config, pose.joints_rad, _legs(pose.legs), pose.legs, placement.number)
        for placement in plan.placements
        for pose in placement.poses
    )
    places = tuple(Placement(one.number, tuple(one.cups_mm[0])) for one in plan.placements)
    return Checklist((*_BALLBAR, *_ALWAYS), stops, places, len(plan.placements[0].cups_mm))


def _of_promise(plan: PromisedPlan) -> Checklist:
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
    stops = tuple(CheckStop(n, q, said("check.nest", nest=nest)) for n, q, nest in of_nests)
    return Checklist((*_TRACKER, *_ALWAYS), stops)


def _legs(legs: Iterable[Leg]) -> Sentence:
    return said("check.legs", number=len(tuple(legs)))


def _targets(targets: Iterable[int]) -> Sentence:
    return said("check.targets", targets=", ".join(map(str, targets)))
