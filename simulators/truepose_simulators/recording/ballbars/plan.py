"""Which ballbar campaign to record: placements of the base fixture, set-ups and poses, from a JSON file."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.scenarios.table import read_table, read_text

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SetupPlan:
    """Where the robot holds the ball of tool nest 1 while a base cup is clamped on it."""

    base_point: int
    joints_deg: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PosePlan:
    """One configuration and the legs that are measured in it, in this order."""

    config: int  # unique in the campaign
    joints_deg: tuple[float, ...]
    legs: tuple[tuple[int, int], ...]  # base point, tool point
    aimed_mm: tuple[float, ...] | None = None  # lengths that an aimed campaign comes near; absent: nominal


@dataclass(frozen=True, slots=True)
class PlacementPlan:
    """One place of the base fixture."""

    number: int  # from 1
    setups: tuple[SetupPlan, ...]  # in the order of clamping
    poses: tuple[PosePlan, ...]
    cups_mm: tuple[Vector, ...] = ()  # nominal, world; where stated, set-ups are checked against them


@dataclass(frozen=True, slots=True)
class BallbarPlan:
    """A whole campaign, placement by placement."""

    placements: tuple[PlacementPlan, ...]


# For whoever draws the cell: the set-ups alone decide where cups come to stand.
_NOT_NEEDED = frozenset({"frame"})


def read_plan(path: Path) -> BallbarPlan:
    """Read a plan file; raises ScenarioError with file, place and key."""
    try:
        document = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        raise ScenarioError(f"{path.name} is not JSON: {error}") from error
    except OSError as error:
        raise ScenarioError(f"{path.name} cannot be read: {error.strerror}") from error
    return plan_from(document, path.name)


def plan_from(document: object, where: str) -> BallbarPlan:
    """Build a plan from what a JSON file contains; raises ScenarioError."""
    if not isinstance(document, Mapping) or not isinstance(document.get("placements"), list):
        raise ScenarioError(f'{where}: key "placements" must be a list')
    placements = [
        _placement(item, f"{where}: placement number {number}")
        for number, item in enumerate(document["placements"], start=1)
    ]
    return BallbarPlan(tuple(placements))


def check_plan(plan: BallbarPlan, cell: Cell) -> None:
    """Raise ScenarioError where a plan does not go with the cell or contradicts itself."""
    if not any(pose.legs for placement in plan.placements for pose in placement.poses):
        raise ScenarioError("the plan has no pose with a leg to measure")
    _check_unique([one.number for one in plan.placements], "placement")
    _check_unique([pose.config for one in plan.placements for pose in one.poses], "config")
    n_nests = len(cell.tool_nests_mm)
    for placement in plan.placements:
        where = f"placement {placement.number}"
        points = sorted(setup.base_point for setup in placement.setups)
        if points not in ([1, 2, 3], [1, 2, 3, 4]):
            raise ScenarioError(f"{where}: set-ups must be of base points 1 to 3 or 1 to 4, not {points}")
        _check_joints(placement.setups, cell, f"{where}, set-up")
        _check_joints(placement.poses, cell, f"{where}, pose")
        for pose in placement.poses:
            _check_legs(pose, len(points), n_nests, where)


def _placement(table: object, where: str) -> PlacementPlan:
    if not isinstance(table, Mapping):
        raise ScenarioError(f"{where} must be a table of keys")
    rest = {key: value for key, value in table.items() if key not in _NOT_NEEDED}
    rest["setups"] = _listed(SetupPlan, rest, "setups", where)
    rest["poses"] = _listed(PosePlan, rest, "poses", where)
    plain = read_table(
        _PlainPlacement, {k: v for k, v in rest.items() if k not in {"setups", "poses"}}, where
    )
    return PlacementPlan(plain.number, rest["setups"], rest["poses"], plain.cups_mm)


@dataclass(frozen=True, slots=True)
class _PlainPlacement:
    """What a placement has besides its lists."""

    number: int
    cups_mm: tuple[Vector, ...] = ()


def _listed(cls: type[T], table: Mapping[str, Any], key: str, where: str) -> tuple[T, ...]:
    entries = table.get(key)
    if not isinstance(entries, list):
        raise ScenarioError(f'{where}: key "{key}" must be a list')
    return tuple(
        read_table(cls, entry, f"{where}, {key}, number {number}")
        for number, entry in enumerate(entries, start=1)
    )


def _check_unique(numbers: Sequence[int], what: str) -> None:
    for number in numbers:
        if number < 1 or numbers.count(number) > 1:
            raise ScenarioError(f"{what} numbers must be 1 or more and unique, see {what} {number}")


def _check_joints(stops: Sequence[SetupPlan | PosePlan], cell: Cell, where: str) -> None:
    n_joints = cell.plant.arm.n_joints
    for number, stop in enumerate(stops, start=1):
        if len(stop.joints_deg) != n_joints:
            raise ScenarioError(f'{where} number {number}: key "joints_deg" must have {n_joints} entries')


def _check_legs(pose: PosePlan, n_cups: int, n_nests: int, where: str) -> None:
    if pose.aimed_mm is not None and len(pose.aimed_mm) != len(pose.legs):
        raise ScenarioError(f'key "aimed_mm" must have {len(pose.legs)} lengths, one per leg')
    for base, tool in pose.legs:
        if not (1 <= base <= n_cups and 1 <= tool <= n_nests):
            raise ScenarioError(
                f"{where}, config {pose.config}: there is no leg {base}-{tool}, only cups 1 to {n_cups} and"
                f" tool nests 1 to {n_nests}"
            )
