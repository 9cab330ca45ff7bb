"""Planned configurations as a table: what a session takes, and what people print."""

from pathlib import Path

import numpy as np

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
    numbers = plan.measured + 1 + np.arange(len(plan.joints_rad))
    cells = stop_cells(Stops(numbers, plan.joints_rad))
    cells |= _NEST.cells(plan.nest) if plan.poses is None else _pose_cells(plan.poses)
    if plan.targets is not None:
        cells["targets"] = [" ".join(map(str, own)) for own in plan.targets]
    file.write_text(table_text(cells), encoding="utf-8", newline="\n")


def _pose_cells(poses: BallbarPoses) -> dict[str, list[str]]:
    legs = [" ".join(f"{base}-{nest}" for base, nest in own) for own in poses.legs]
    return {**_PLACEMENT.cells(poses.placement), "legs": legs}
