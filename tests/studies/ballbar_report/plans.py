"""Plans of the sessions that are compared, made once and kept as files that a recorder reads."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from truepose.domain.ballbar import BallbarPlan, PlannedPlacement, PlannedPose
from truepose.exchange.cells.file import simulated_cell
from truepose.exchange.json_text import render_json
from truepose.planning.ballbar.plan import ballbar_plan

_CELL: Final = "lrmate-tilted"  # a plan sees the nominal robot only, which is that of everyday robots too


@dataclass(frozen=True, slots=True)
class PlanKind:
    """A kind of session."""

    key: str
    label: str
    placements: int
    base_points: int
    poses: int = 64  # of the whole session; the thesis had 61 to 66


KINDS: Final = (
    PlanKind("one", "one placement", 1, 3),
    PlanKind("fourth-cup", "one placement with a fourth cup", 1, 4),
    PlanKind("four", "four placements", 4, 3),
)


def plan_path(kind: PlanKind, folder: Path) -> Path:
    """Return where the plan of a kind is kept."""
    return folder / f"{kind.key}.json"


def made_plan(kind: PlanKind, folder: Path) -> Path:
    """Make the plan of a kind unless its file is there.

    Raises
    ------
    TrueposeError
        The arm does not offer such a session.
    """
    path = plan_path(kind, folder)
    if not path.is_file():
        cell = simulated_cell(_CELL, 0)
        plan = ballbar_plan(cell, placements=kind.placements, base_points=kind.base_points, poses=kind.poses)
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(render_json(plan_document(plan)) + "\n", encoding="utf-8")
    return path


def plan_document(plan: BallbarPlan) -> dict[str, Any]:
    """Return a plan as the recorder of campaigns reads it; joints in deg."""
    return {"placements": [_placement(placement) for placement in plan.placements]}


def _placement(placement: PlannedPlacement) -> dict[str, Any]:
    return {
        "number": placement.number,
        "cups_mm": [list(cup) for cup in placement.cups_mm],
        "setups": [
            {"base_point": setup.base_point, "joints_deg": _degrees(setup.joints_rad)}
            for setup in placement.setups
        ],
        "poses": [_pose(pose) for pose in placement.poses],
    }


def _pose(pose: PlannedPose) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "config": pose.config,
        "joints_deg": _degrees(pose.joints_rad),
        "legs": [list(leg) for leg in pose.legs],
    }
    return entry if pose.aimed_mm is None else entry | {"aimed_mm": list(pose.aimed_mm)}


def _degrees(joints_rad: tuple[float, ...]) -> list[float]:
    return [float(angle) for angle in np.degrees(joints_rad)]
