"""What a page draws of an instrument in its cell: what it sees, what is hidden, where it would see more.

Sight is judged as plans are: a corner cube is seen within its acceptance, and not through the robot's
column. What stands about in a cell nobody has told this program.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.cell import Cell
from truepose.domain.contacts import ContactPlan
from truepose.domain.session import PlannedStop, Registration, Vector
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import placement_translation, rotation_z
from truepose.planning.workspace.space import (
    WorkSpace,
    cosines_to_tracker,
    nest_places,
    nominal_chain,
    space_of_cell,
)
from truepose.sessions.engine.nominal_arm import arm_line, as_vector
from truepose.sessions.guide.guide import Fixed

# Of an AT901, the narrower of the two heads that the drivers know; an AT40x begins to measure at 1.5 m.
ELEVATION_RAD: Final = math.radians(45.0)
NEAREST_MM: Final = 1500.0

_TURNS_DEG: Final = (-40, -20, 0, 20, 40)  # about the robot, at which another place is looked for
_CLIMBS_MM: Final = (-300.0, 0.0, 300.0)
_NEARER: Final = (0.85, 1.0, 1.2)  # times the distance of now
_WORTH: Final = 2  # configurations more that make somebody carry a tracker

WhyHidden: TypeAlias = Literal["turned_away", "behind_column", "too_steep", "too_near"]


@dataclass(frozen=True, slots=True)
class SeenPoint:
    """A fixed nest, or the tool nest of one configuration, where the nominal robot has it."""

    name: str
    position_mm: Vector
    config: int | None
    hidden: WhyHidden | None  # None: it can be seen


@dataclass(frozen=True, slots=True)
class BetterPlace:
    """Where the instrument would see more."""

    position_mm: Vector
    configurations: int  # that are seen from there


@dataclass(frozen=True, slots=True)
class GuidedScene:
    """Geometry in the world."""

    arm_mm: tuple[Vector, ...]  # from the base to the flange frame, where the next configuration has it
    instrument_mm: Vector | None
    placed: bool  # the instrument's place was measured, not only stated
    fixed_nests: tuple[SeenPoint, ...]
    stops: tuple[SeenPoint, ...]
    better: BetterPlace | None
    stand_mm: Vector  # of whoever looks at the picture
    look_at_mm: Vector


def guided_scene(fixed: Fixed, registration: Registration | None, config: int | None) -> GuidedScene:
    """Return the picture of a session; the arm stands where `config` has it, else at the first stop."""
    cell, plan = fixed.setup.cell, fixed.plan
    configs = [stop.config for stop in plan.stops]
    number = configs.index(config) if config in configs else 0
    # Where the tracker was measured to stand outranks where the cell file puts it.
    space = replace(space_of_cell(cell, (), None), tracker_position_mm=_place(cell, registration))
    chain = nominal_chain(space, np.array([stop.joints_rad for stop in plan.stops]))
    stops = () if isinstance(plan, ContactPlan) else plan.stops
    points = _stops(space, chain, stops) if stops else ()
    nests = _fixed_nests(cell, space)
    return GuidedScene(
        arm_mm=tuple(map(_vector, arm_line(chain, number))),
        instrument_mm=space.tracker_position_mm if stops else None,
        placed=registration is not None,
        fixed_nests=nests,
        stops=points,
        better=_better(space, chain, stops) if stops and registration is None else None,
        **_view_of(space, [point.position_mm for point in (*nests, *points)]),
    )


def _place(cell: Cell, registration: Registration | None) -> Vector | None:
    if registration is not None:
        return _vector(registration.translation_mm)
    return cell.camera.position_mm if cell.camera is not None else cell.tracker_position_mm


def _fixed_nests(cell: Cell, space: WorkSpace) -> tuple[SeenPoint, ...]:
    return tuple(
        SeenPoint(f"F{number}", nest.centre_mm, None, _out_of_head(space, np.array([nest.centre_mm]))[0])
        for number, nest in enumerate(cell.fixed_nests, 1)
    )


def _stops(space: WorkSpace, chain: Chain, stops: tuple[PlannedStop, ...]) -> tuple[SeenPoint, ...]:
    places = _places(space, chain, stops)
    beyond = _out_of_head(space, places)
    cosines = _cosines(space, chain, stops)
    return tuple(
        SeenPoint(
            f"T{stop.nest}", _vector(places[i]), stop.config, _hidden(float(cosines[i]), space) or beyond[i]
        )
        for i, stop in enumerate(stops)
    )


def _hidden(cosine: float, space: WorkSpace) -> WhyHidden | None:
    if cosine >= math.cos(space.seen_within_rad):
        return None
    return "turned_away" if math.isfinite(cosine) else "behind_column"


def _out_of_head(space: WorkSpace, places_mm: FloatArray) -> list[WhyHidden | None]:
    """Return what the instrument's own head forbids at each of n places (n, 3)."""
    if space.tracker_position_mm is None:
        return [None] * len(places_mm)
    ways = places_mm - np.array(space.tracker_position_mm)
    steep = np.abs(np.arctan2(ways[:, 2], np.hypot(ways[:, 0], ways[:, 1]))) > ELEVATION_RAD
    near = np.linalg.norm(ways, axis=1) < NEAREST_MM
    return ["too_steep" if s else "too_near" if n else None for s, n in zip(steep, near, strict=True)]


def _places(space: WorkSpace, chain: Chain, stops: tuple[PlannedStop, ...]) -> FloatArray:
    """Return where the nest of each stop is [mm, world], shape (n, 3)."""
    return _of_stops(nest_places(space, chain), stops)


def _cosines(space: WorkSpace, chain: Chain, stops: tuple[PlannedStop, ...]) -> FloatArray:
    return _of_stops(cosines_to_tracker(space, chain), stops)


def _of_stops(of_nests: FloatArray, stops: tuple[PlannedStop, ...]) -> FloatArray:
    chosen: FloatArray = of_nests[[stop.nest - 1 for stop in stops], np.arange(len(stops))]
    return chosen


def _better(space: WorkSpace, chain: Chain, stops: tuple[PlannedStop, ...]) -> BetterPlace | None:
    """Return the place round about from which most is seen; None where it is not worth the way."""
    if space.tracker_position_mm is None or space.camera is not None:
        return None
    places = _places(space, chain, stops)

    def seen(place: Vector) -> int:
        there = replace(space, tracker_position_mm=place)
        return int(np.sum(_are_seen(there, _cosines(there, chain, stops), places)))

    now = seen(space.tracker_position_mm)
    if now == len(stops):
        return None
    best = max(_round_about(space, space.tracker_position_mm), key=seen)
    return BetterPlace(best, seen(best)) if seen(best) >= now + _WORTH else None


def _are_seen(space: WorkSpace, cosines: FloatArray, places: FloatArray) -> BoolArray:
    free = np.array([why is None for why in _out_of_head(space, places)])
    found: BoolArray = free & (cosines >= math.cos(space.seen_within_rad))
    return found


def _round_about(space: WorkSpace, place: Vector) -> Iterator[Vector]:
    base = placement_translation(space.base)
    for turn in _TURNS_DEG:
        for share in _NEARER:
            for climb in _CLIMBS_MM:
                way = rotation_z(math.radians(turn)) @ (np.array(place) - base)
                yield _vector(base + np.array([share, share, 1.0]) * way + np.array([0.0, 0.0, climb]))


def _view_of(space: WorkSpace, shown: list[Vector]) -> dict[str, Vector]:
    """Return what is looked at, and from where: across the beam, from above."""
    base = placement_translation(space.base)
    tracker = base if space.tracker_position_mm is None else np.array(space.tracker_position_mm)
    corners = np.array([base, tracker, *shown])
    centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    beam = tracker[:2] - base[:2]
    ahead = math.atan2(beam[1], beam[0]) if np.linalg.norm(beam) > 1.0 else 0.0
    away = np.array([math.cos(ahead + math.radians(60)), math.sin(ahead + math.radians(60)), 0.75])
    return {"stand_mm": _vector(centre + size * away), "look_at_mm": _vector(centre)}


def _vector(point: FloatArray) -> Vector:
    return as_vector(point, digits=3)
