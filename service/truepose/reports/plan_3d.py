"""A session in space: where the plan sends the arm, what was measured, bars between cups and nests."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import BallbarPlan, Leg
from truepose.domain.cell import Cell
from truepose.domain.robot import FramePlacement, Robot
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.planning.ballbar.bodies import arm_body, arm_links, chain_of, table_arm_radii_mm
from truepose.planning.workspace.bodies import arm_outline

_TABLE_REACH_MM: Final = 1000.0  # stretched length of the arms that `table_arm_radii_mm` were read off
_LEAST, _MOST = 0.5, 4.0  # by which a picture's arm is thinner or thicker than those
_NEST_RADIUS_MM: Final = 8.0


def arm_pieces(
    robot: Robot, base: FramePlacement, nests_mm: FloatArray, joints_rad: FloatArray
) -> FloatArray:
    """Return links and tool in configurations.

    Parameters
    ----------
    robot : Robot
    base : FramePlacement
        In the world.
    nests_mm : (K, 3) array
        In the flange frame [mm].
    joints_rad : (n, J) array

    Returns
    -------
    (n, m + K, 7) array
        Start, end and radius of the m links and of what leads from the flange to each nest, world [mm].
    """
    outline = arm_outline(robot, base)
    chain = chain_of(outline, joints_rad)
    links = arm_body(outline, chain)
    radii = _thickness(robot) * np.array(table_arm_radii_mm(robot.n_joints))[list(arm_links(outline))]
    arm = _pieces(links.start_mm, links.end_mm, radii)
    flange = np.broadcast_to(chain.points(np.zeros(3)), (len(nests_mm), len(joints_rad), 3))
    nests = np.array([chain.points(nest) for nest in nests_mm]).reshape(flange.shape)
    return np.concatenate([arm, _pieces(flange, nests, np.full(len(nests_mm), _NEST_RADIUS_MM))], axis=1)


def _thickness(robot: Robot) -> float:
    stretched = sum(abs(row.a_mm) + abs(row.d_mm) for row in robot.joints)
    return float(np.clip(stretched / _TABLE_REACH_MM, _LEAST, _MOST))


def _pieces(start_mm: FloatArray, end_mm: FloatArray, radius_mm: FloatArray) -> FloatArray:
    """Return capsules (m, n, 3) as rows of configurations, shape (n, m, 7)."""
    radius = np.broadcast_to(radius_mm[:, None, None], (*start_mm.shape[:2], 1))
    return np.concatenate([start_mm, end_mm, radius], axis=2).transpose(1, 0, 2)


StopState: TypeAlias = Literal["measured", "skipped", "to_come"]
_BAR_MM: Final = 8.0  # radius of a ballbar as it is drawn


@dataclass(frozen=True, slots=True)
class Place:
    """Where the plan sends the arm, and the legs that are measured there."""

    config: int
    joints_rad: tuple[float, ...]
    nest: int  # 1-based, that is measured; 0: none alone
    cups_mm: tuple[tuple[float, float, float], ...] = ()
    legs: tuple[Leg, ...] = ()


@dataclass(frozen=True, slots=True)
class PlannedPlace:
    """A stop as a picture shows it, in the world."""

    config: int
    state: StopState
    place_mm: FloatArray  # (3,) of the nest, or of the flange
    pieces_mm: FloatArray  # (m, 7) arm, tool and bars


@dataclass(frozen=True, slots=True)
class PlanSpace:
    """A plan in space, its stops in order."""

    robot: str
    stops: tuple[PlannedPlace, ...]
    next: int | None  # index of the stop that comes next; None: none is left
    fixed_mm: FloatArray  # (k, 3) fixed nests and cups
    instrument_mm: tuple[float, float, float] | None


def ballbar_places(plan: BallbarPlan) -> tuple[Place, ...]:
    """Return the poses of a ballbar plan with their legs, placement by placement."""
    return tuple(
        Place(pose.config, pose.joints_rad, 0, placement.cups_mm, pose.legs)
        for placement in plan.placements
        for pose in placement.poses
    )


def plan_space(
    cell: Cell,
    places: Sequence[Place],
    states: Mapping[int, StopState],
    instrument_mm: tuple[float, float, float] | None,
) -> PlanSpace:
    """Return a plan in space by the nominal robot.

    Parameters
    ----------
    cell : Cell
        With which the session was planned.
    places : sequence of Place
    states : mapping
        Of configurations that were measured or skipped; all others are to come.
    instrument_mm : (float, float, float), optional
        Where the tracker stands, as far as it is known.
    """
    stops = _stops(cell, places, states) if places else ()
    waiting = [index for index, stop in enumerate(stops) if stop.state == "to_come"]
    cups = [cup for place in places for cup in place.cups_mm]
    fixed = [nest.centre_mm for nest in cell.fixed_nests]
    return PlanSpace(
        robot=cell.robot.name,
        stops=stops,
        next=waiting[0] if waiting else None,
        fixed_mm=np.unique(np.array([*fixed, *cups]).reshape(-1, 3), axis=0),
        instrument_mm=instrument_mm,
    )


def _stops(cell: Cell, places: Sequence[Place], states: Mapping[int, StopState]) -> tuple[PlannedPlace, ...]:
    joints = np.array([place.joints_rad for place in places])
    nests = {k: nest.centre_mm for k, nest in enumerate(cell.nests, 1) if nest.centre_mm is not None}
    arms = arm_pieces(cell.robot, cell.base_nominal, np.array(list(nests.values())).reshape(-1, 3), joints)
    base = cell.base_nominal
    chain = forward(nominal_values(cell.robot, joints), placement_rotation(base), placement_translation(base))
    ends = {k: chain.points(np.array(centre)) for k, centre in {0: (0.0, 0.0, 0.0), **nests}.items()}
    return tuple(
        PlannedPlace(
            place.config,
            states.get(place.config, "to_come"),
            ends.get(place.nest, ends[0])[row],
            np.concatenate([arms[row], _bars(place, {k: at[row] for k, at in ends.items()})]),
        )
        for row, place in enumerate(places)
    )


def _bars(place: Place, nests_mm: Mapping[int, FloatArray]) -> FloatArray:
    """Return the bars of a pose, shape (legs, 7)."""
    bars = [
        [*place.cups_mm[cup - 1], *nests_mm[nest], _BAR_MM]
        for cup, nest in place.legs
        if nest in nests_mm and cup <= len(place.cups_mm)
    ]
    return np.array(bars).reshape(-1, 7)
