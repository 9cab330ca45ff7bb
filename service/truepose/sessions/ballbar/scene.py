"""What a page draws of the present step: cups, nests and arm, seen from where the person stands."""

import math
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import BallbarStep, PlannedPlacement, StepKind, Vector
from truepose.domain.cell import Cell
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import placement_translation
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.service import BallbarView
from truepose.sessions.engine.nominal_arm import arm_line, as_vector, nominal_chain

PointKind: TypeAlias = Literal["cup", "nest"]
_DISTANCE_MM: Final = 1200.0  # from which a person looks before reaching in
_EYES_ABOVE_MM: Final = 500.0  # of a person who stands at a table, over what is looked at
_SIDES_DEG: Final = range(-75, 76, 15)  # of the direction away from the robot, from which one may look


@dataclass(frozen=True, slots=True)
class ScenePoint:
    """A cup or a nest."""

    name: str
    position_mm: Vector
    kind: PointKind


@dataclass(frozen=True, slots=True)
class Scene:
    """Geometry in the world for one step."""

    points: tuple[ScenePoint, ...]
    arm_mm: tuple[Vector, ...]  # from the base to the flange frame, for this step; the base alone: not known
    leg: tuple[str, str] | None
    stand_mm: Vector  # the person's eyes
    look_at_mm: Vector
    before_move_arm_mm: tuple[Vector, ...] | None  # of a motion: where the arm is now, as far as known


def scene_of(view: BallbarView) -> Scene:
    """Return the geometry of the present step; where nothing is left to do, of the cell as it stands."""
    found, cell = view.situation, view.setup.cell
    step = found.step
    standing = None if found.arrival is None else np.array(found.arrival.reported_rad)
    target = None if step is None or step.target_rad is None else np.array(step.target_rad)
    there = standing if target is None else target
    leg = _leg(step)
    # Nobody knows where the arm is before its first motion. The tool's triangle is the same anywhere.
    of_tool = there is None and leg is not None
    chain = _chain(cell, np.zeros(cell.robot.n_joints) if there is None else there)
    points = (*_cups(_placement(view, step)), *(_nests(cell, chain) if of_tool or there is not None else ()))
    base_mm = placement_translation(cell.base_nominal)
    look_at, stand = _view_of(points, step, base_mm)
    return Scene(
        points=points,
        arm_mm=(_vector(base_mm),) if there is None else _arm(chain),
        leg=leg,
        stand_mm=stand,
        look_at_mm=look_at,
        before_move_arm_mm=None if target is None or standing is None else _arm(_chain(cell, standing)),
    )


def _chain(cell: Cell, joints_rad: FloatArray) -> Chain:
    return nominal_chain(cell.robot, cell.base_nominal, joints_rad[None])


def _arm(chain: Chain) -> tuple[Vector, ...]:
    return tuple(map(_vector, arm_line(chain)))


def _placement(view: BallbarView, step: BallbarStep | None) -> PlannedPlacement | None:
    """Return the placement of a step; before the first one is put down there are no cups to see."""
    number = None if step is None else step.placement
    return next((place for place in view.plan.placements if place.number == number), None)


def _cups(placement: PlannedPlacement | None) -> tuple[ScenePoint, ...]:
    cups = () if placement is None else placement.cups_mm
    return tuple(ScenePoint(f"B{number}", cup, "cup") for number, cup in enumerate(cups, 1))


def _nests(cell: Cell, chain: Chain) -> tuple[ScenePoint, ...]:
    return tuple(
        ScenePoint(f"T{number}", _vector(chain.points(np.array(nest.centre_mm))[0]), "nest")
        for number, nest in enumerate(cell.nests, 1)
        if nest.centre_mm is not None
    )


def _leg(step: BallbarStep | None) -> tuple[str, str] | None:
    """Return the names of the two points that the ballbar joins."""
    if step is None or step.points is None:
        return None
    of_leg = step.kind is StepKind.CONNECT_LEG
    first = "B" if of_leg or step_side(step) == "base" else "T"
    second = "T" if of_leg else first
    return f"{first}{step.points[0]}", f"{second}{step.points[1]}"


def step_side(step: BallbarStep) -> Literal["tool", "base"]:
    """Return the triangle of a side that is measured."""
    return step.artefact or ("tool" if step.id.startswith(step_ids.TOOL) else "base")


def _view_of(
    points: tuple[ScenePoint, ...], step: BallbarStep | None, base_mm: FloatArray
) -> tuple[Vector, Vector]:
    """Return what the person looks at, and from where: away from the robot, with the legs broadside."""
    shown = _looked_at(points, step)
    centre = np.mean([point.position_mm for point in shown], axis=0) if shown else base_mm
    spread = np.array([point.position_mm for point in shown]) - centre if shown else np.zeros((1, 3))
    outward = centre[:2] - base_mm[:2]
    ahead = math.atan2(outward[1], outward[0]) if np.linalg.norm(outward) > 1.0 else 0.0
    best = max(_SIDES_DEG, key=lambda side: _seen(spread, ahead + math.radians(side), side))
    azimuth = ahead + math.radians(best)
    away = np.array([_DISTANCE_MM * math.cos(azimuth), _DISTANCE_MM * math.sin(azimuth), _EYES_ABOVE_MM])
    return _vector(centre), _vector(centre + away)


def _looked_at(points: tuple[ScenePoint, ...], step: BallbarStep | None) -> list[ScenePoint]:
    """Return the points that fix the view; all of a pose, so that it stays while its legs are connected."""
    if step is not None and step.base_point is not None:
        named = {f"B{step.base_point}", "T1"}
    elif step is not None and step.kind is StepKind.MEASURE_SIDE:
        kind: PointKind = "nest" if step_side(step) == "tool" else "cup"
        named = {point.name for point in points if point.kind == kind}
    else:
        named = set()
    return [point for point in points if point.name in named or not named] or list(points)


def _seen(spread_mm: FloatArray, azimuth: float, side_deg: int) -> float:
    """Return how far apart the points appear from a side, less the farther one must walk around."""
    across = np.array([-math.sin(azimuth), math.cos(azimuth)])
    return float(np.ptp(spread_mm[:, :2] @ across)) * math.cos(math.radians(side_deg) / 2)


def _vector(point: FloatArray) -> Vector:
    # A page draws pixels: micrometres are more than enough, and shorter documents travel faster to a tablet.
    return as_vector(point, digits=3)
