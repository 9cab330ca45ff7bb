"""Robots of one's own: one reader a format, told by the ending of the file's name.

A reader is imported when a file of its kind is read: most robots are shipped ones, and parsers take time.
"""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.robots.shipped import RobotWithTool, read_toml_robot

_TIP: Final = re.compile(r"(?P<file>.+\.urdf)#(?P<tip>.+)", re.IGNORECASE)


def _read_urdf(path: Path) -> RobotWithTool:
    """Read a URDF; behind a `#` stands the link at its tip."""
    from truepose.exchange.robots.urdf.reading import read_urdf

    name, tip = _and_tip(path.name)
    return RobotWithTool(read_urdf(path.with_name(name), tip=tip).robot, nests=())


def _read_kinematics(path: Path) -> RobotWithTool:
    from truepose.exchange.robots.calibrated_kinematics import read_calibrated_kinematics

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
    return Path(_and_tip(name)[0]).suffix.lower()


def _and_tip(name: str) -> tuple[str, str | None]:
    """Return the name of a file, and of the link that stands behind that of a URDF."""
    match = _TIP.fullmatch(name)
    return (match["file"], match["tip"]) if match else (name, None)
