"""A robot by its name, and as the keys of `campaign.json` that describe it."""

from pathlib import Path
from typing import Final

from truepose.domain.robot import Robot
from truepose.exchange.robots.document import robot_document
from truepose.exchange.robots.files import is_robot_file, read_robot_file
from truepose.exchange.robots.shipped import load_robot

_NOT_IN_A_CAMPAIGN: Final = (
    "calibration_ranges_deg",
    "joint_limits_deg",
    "rated_payload_kg",
    "source",
    "name",
)
_GRAVITY_M_S2: Final = (0.0, 0.0, -9.81)


def named_robot(given: str | Path) -> Robot:
    """Return a shipped robot or that of a file.

    Raises
    ------
    UnknownRobotError, InputFileError
        No shipped robot has that name; the file cannot be used.
    """
    if isinstance(given, Path) or is_robot_file(given):
        return read_robot_file(Path(given)).robot
    return load_robot(given)


def campaign_keys(robot: Robot) -> dict[str, object]:
    """Return the keys that describe a robot whose masses nobody stated."""
    stated = {key: value for key, value in robot_document(robot).items() if key not in _NOT_IN_A_CAMPAIGN}
    return {**without_masses(), "robot": robot.name, **stated}


def without_masses() -> dict[str, object]:
    """Return the keys of a robot that stands upright and says nothing of its masses."""
    return {"gravity_m_s2_world": list(_GRAVITY_M_S2), "masses": []}
