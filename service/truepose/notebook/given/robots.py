"""The nominal robot of data in memory: a shipped one, a file, or a table of one's own."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from truepose.domain.measurement.campaign import Campaign
from truepose.domain.robot import Robot
from truepose.exchange.robots.campaign_keys import campaign_keys, named_robot, without_masses
from truepose.notebook.given.tables import Table, columns_of

RobotGiven: TypeAlias = str | Path | Table | Sequence[Mapping[str, float]]

_ANGLES = ("alpha", "theta_offset", "beta")


def known_robot(given: RobotGiven) -> Robot | None:
    """Return a shipped robot or that of a file, None where `given` is a table.

    Raises
    ------
    UnknownRobotError, InputFileError
        No shipped robot has that name; the file cannot be used.
    """
    return named_robot(given) if isinstance(given, str | Path) else None


def robot_keys(given: RobotGiven, robot: Robot | None) -> dict[str, object]:
    """Return the keys of `campaign.json` that describe the robot."""
    if robot is None:
        return without_masses() | {"robot": "robot of a table", "dhm_nominal": _rows(given)}
    return campaign_keys(robot)


def with_limits_of(campaign: Campaign, robot: Robot | None) -> Campaign:
    """Return the campaign whose robot also has what the file format of a campaign cannot hold."""
    if robot is None:
        return campaign
    more = {
        name: getattr(robot, name)
        for name in ("calibration_ranges", "joint_limits", "rated_payload_kg", "source")
    }
    return replace(campaign, robot=replace(campaign.robot, **more))


def _rows(given: Any) -> list[dict[str, object]]:
    """Return the rows of a Denavit-Hartenberg table, numbered where they are not."""
    if isinstance(given, Sequence):
        rows = [dict(row) for row in given]
    else:
        columns = columns_of(given, "robot")
        n = max(map(len, columns.values()), default=0)
        rows = [{name: values[k].item() for name, values in columns.items()} for k in range(n)]
    return [{"joint": number, **_in_degrees(row)} for number, row in enumerate(rows, start=1)]


def _in_degrees(row: Mapping[str, object]) -> dict[str, object]:
    turned = {f"{angle}_rad": f"{angle}_deg" for angle in _ANGLES}
    return {
        turned.get(name, name): float(np.degrees(value))
        if name in turned and isinstance(value, float | int)
        else value
        for name, value in row.items()
    }
