"""Planned configurations as a table: what a session takes, and what people print."""

from pathlib import Path

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import Stops
from truepose.exchange.tables.fields import Field, table_text
from truepose.exchange.tables.stops import stop_cells
from truepose.exchange.tables.table import Column
from truepose.planning.promise.plan import BallbarPoses, PromisedPlan

_NEST = Field("nest", Column("nest"))
_PLACEMENT = Field("placement", Column("placement"))


def write_plan(file: Path, plan: PromisedPlan) -> None:
    """Write `config, q1_deg..` and the `nest` that faces the tracker, or `placement, legs` of a ballbar.

    Stops of a closed loop say the `targets` that are read there as well.

    Configurations are numbered on from those that were measured.
    """
    if plan.poses is None and plan.targets is None:
        write_configurations(file, plan.joints_rad, plan.nest, plan.measured)
        return
    cells = _numbered(plan.joints_rad, plan.measured)
    cells |= _NEST.cells(plan.nest) if plan.poses is None else _pose_cells(plan.poses)
    if plan.targets is not None:
        cells["targets"] = [" ".join(map(str, own)) for own in plan.targets]
    file.write_text(table_text(cells), encoding="utf-8", newline="\n")


def write_configurations(
    file: Path, joints_rad: FloatArray, nest: IntArray | None, measured: int = 0
) -> None:
    """Write configurations (n, J) and the nest of each (n,), numbered on from those that were measured."""
    cells = _numbered(joints_rad, measured) | _NEST.cells(nest)
    file.write_text(table_text(cells), encoding="utf-8", newline="\n")


def _numbered(joints_rad: FloatArray, measured: int) -> dict[str, list[str]]:
    return stop_cells(Stops(measured + 1 + np.arange(len(joints_rad)), joints_rad))


def _pose_cells(poses: BallbarPoses) -> dict[str, list[str]]:
    legs = [" ".join(f"{base}-{nest}" for base, nest in own) for own in poses.legs]
    return {**_PLACEMENT.cells(poses.placement), "legs": legs}
