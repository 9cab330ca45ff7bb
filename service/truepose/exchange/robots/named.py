"""Robots by name: the shipped ones, one TOML file each beside this one, and files of one's own.

A reader is imported when a file of its kind is read: most robots are shipped ones, and parsers take time.

Campaigns do not state limits. A robot whose name has that of a shipped one in it ("ABB IRB 120, cell 4"), and
whose table of joints is the same, has the limits that its maker publishes.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Final

import numpy as np

from truepose.domain.identification import Model
from truepose.domain.robot import Nest, Robot
from truepose.exchange.document import read_bytes, toml_document
from truepose.exchange.errors import UnknownRobotError, UnreadableFileError
from truepose.exchange.robots.document import read_joints, read_nest, read_robot, robot_document

_SUFFIX = ".toml"


@dataclass(frozen=True, slots=True)
class RobotWithTool:
    """A nominal robot and the tool nests of the artefact that its masses include, if any."""

    robot: Robot
    nests: tuple[Nest, ...]


def list_robots() -> tuple[str, ...]:
    """Return the names of the shipped robots, sorted."""
    return tuple(
        sorted(entry.name.removesuffix(_SUFFIX) for entry in _folder().iterdir() if _is_robot(entry))
    )


def load_robot(name: str) -> Robot:
    """Return a shipped robot; raises UnknownRobotError, which lists the known names."""
    return load_robot_with_tool(name).robot


@cache
def load_robot_with_tool(name: str) -> RobotWithTool:
    """Return a shipped robot with its tool nests; raises UnknownRobotError.

    It is read once: robots cannot be changed, and pages list all of them.
    """
    if name not in list_robots():
        raise UnknownRobotError(
            f"No robot is called {name!r}; the shipped ones are {', '.join(list_robots())}."
        )
    entry = _folder() / (name + _SUFFIX)
    return _parse(entry.name, entry.read_bytes())


def read_toml_robot(path: Path) -> RobotWithTool:
    """Read a robot of one's own, in the form of the shipped files; raises InputFileError."""
    return _parse(path.name, read_bytes(path))


def _folder() -> Traversable:
    return files("truepose.exchange") / "robots"


def _is_robot(entry: Traversable) -> bool:
    return entry.is_file() and entry.name.endswith(_SUFFIX)


def _parse(file: str, data: bytes) -> RobotWithTool:
    root = toml_document(file, data)
    joints = read_joints(root.key("dhm_nominal"))
    nests = root.optional("tool_nest")
    return RobotWithTool(
        robot=read_robot(root, root.key("name").text(), joints),
        nests=() if nests is None else tuple(read_nest(entry) for entry in nests.items()),
    )


_TIP: Final = re.compile(r"(?P<file>.+\.urdf)#(?P<tip>.+)", re.IGNORECASE)


def _read_urdf(path: Path) -> RobotWithTool:
    """Read a URDF; behind a `#` stands the link at its tip."""
    from truepose.exchange.robots.urdf_import import read_urdf

    name, tip = _and_tip(path.name)
    return RobotWithTool(read_urdf(path.with_name(name), tip=tip).robot, nests=())


def _read_kinematics(path: Path) -> RobotWithTool:
    from truepose.exchange.robots.ros_calibrated_kinematics import read_calibrated_kinematics

    return RobotWithTool(read_calibrated_kinematics(path), nests=())


_READERS: Final[Mapping[str, Callable[[Path], RobotWithTool]]] = {
    ".toml": read_toml_robot,
    ".urdf": _read_urdf,
    ".yaml": _read_kinematics,
    ".yml": _read_kinematics,
}
ENDINGS: Final = tuple(_READERS)


def is_robot_file(name: str) -> bool:
    """Whether a name is that of a file, not of a shipped robot."""
    return _ending(name) in _READERS


def read_robot_file(path: Path) -> RobotWithTool:
    """Read a robot of one's own; raises InputFileError.

    Of a URDF that has several ends, `arm.urdf#tool0` names the link at the tip.
    """
    reader = _READERS.get(_ending(path.name))
    if reader is None:
        raise UnreadableFileError(
            f"this is not the name of a robot file; its name ends in {', '.join(ENDINGS)}", file=path.name
        )
    return reader(path)


def _ending(name: str) -> str:
    return Path(_and_tip(name)[0]).suffix.lower()


def _and_tip(name: str) -> tuple[str, str | None]:
    """Return the name of a file, and of the link that stands behind that of a URDF."""
    match = _TIP.fullmatch(name)
    return (match["file"], match["tip"]) if match else (name, None)


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


_ROUNDING: Final = 1e-6  # of a file, in mm and rad


def with_known_limits(model: Model) -> Model:
    """Return a model whose robot has its published limits, if it says none and they are known."""
    if model.robot.joint_limits is not None:
        return model
    found = next((known for known in _known() if _same(model.robot, known)), None)
    return (
        model
        if found is None
        else replace(model, robot=replace(model.robot, joint_limits=found.joint_limits))
    )


@cache
def _known() -> tuple[Robot, ...]:
    return tuple(load_robot(name) for name in list_robots())


def _same(robot: Robot, known: Robot) -> bool:
    """Whether a robot has the name and the table of a known one."""
    # Both, name and table: limits of a sister arm would let a correction go where this one is stopped.
    if _plain(known.name) not in _plain(robot.name) or robot.n_joints != known.n_joints:
        return False
    return bool(np.allclose(robot.table, known.table, rtol=0.0, atol=_ROUNDING))


def _plain(name: str) -> str:
    return "".join(filter(str.isalnum, name.casefold()))
