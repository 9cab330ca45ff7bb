"""A session in space: where the plan sends the arm, what was measured, bars between cups and nests."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell.description import Cell
from truepose.domain.measurement.ballbar import BallbarPlan, Leg
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.reports.spaces.arm import arm_pieces

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
