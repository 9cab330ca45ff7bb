"""The nominal robot of data in memory: a shipped one, a file, or a table of one's own."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from truepose.domain.campaign import Campaign
from truepose.domain.robot import Robot
from truepose.exchange.robots.document import robot_document
from truepose.exchange.robots.files import is_robot_file, read_robot_file
from truepose.exchange.robots.shipped import load_robot
from truepose.notebook.tables import Table, columns_of

RobotGiven: TypeAlias = str | Path | Table | Sequence[Mapping[str, float]]

_ANGLES = ("alpha", "theta_offset", "beta")
_NOT_IN_A_CAMPAIGN = ("calibration_ranges_deg", "joint_limits_deg", "rated_payload_kg", "source", "name")
_GRAVITY_M_S2 = [0.0, 0.0, -9.81]


def known_robot(given: RobotGiven) -> Robot | None:
    """Return a shipped robot or that of a file, None where `given` is a table.

    Raises
    ------
    UnknownRobotError, InputFileError
        No shipped robot has that name; the file cannot be used.
    """
    if isinstance(given, Path) or (isinstance(given, str) and is_robot_file(given)):
        return read_robot_file(Path(given)).robot
    return load_robot(given) if isinstance(given, str) else None


def robot_keys(given: RobotGiven, robot: Robot | None) -> dict[str, object]:
    """Return the keys of `campaign.json` that describe the robot."""
    common: dict[str, object] = {"gravity_m_s2_world": _GRAVITY_M_S2, "masses": []}
    if robot is None:
        return common | {"robot": "robot of a table", "dhm_nominal": _rows(given)}
    document = robot_document(robot)
    return common | {
        "robot": robot.name,
        **{key: value for key, value in document.items() if key not in _NOT_IN_A_CAMPAIGN},
    }


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
