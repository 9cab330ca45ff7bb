"""Robots of one's own: one reader a format, told by the ending of the file's name."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.robots.calibrated_kinematics import read_calibrated_kinematics
from truepose.exchange.robots.shipped import RobotWithTool, read_toml_robot
from truepose.exchange.robots.urdf.reading import read_urdf


def _read_urdf(path: Path) -> RobotWithTool:
    """Read a URDF; behind a `#` stands the link at its tip."""
    name, _, tip = path.name.partition("#")
    return RobotWithTool(read_urdf(path.with_name(name), tip=tip or None).robot, nests=())


def _read_kinematics(path: Path) -> RobotWithTool:
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
            f"this is no file of a robot by its name; one ends in {', '.join(ENDINGS)}", file=path.name
        )
    return reader(path)


def _ending(name: str) -> str:
    return Path(name.partition("#")[0]).suffix.lower()
