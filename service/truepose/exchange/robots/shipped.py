"""Robots shipped as data: one TOML file each in `robots/`, with the source of its numbers."""

from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from truepose.domain.robot import Nest, Robot
from truepose.exchange.document import toml_document
from truepose.exchange.errors import UnknownRobotError
from truepose.exchange.input_file import read_bytes
from truepose.exchange.robots.document import read_joints, read_nest, read_robot

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


def load_robot_with_tool(name: str) -> RobotWithTool:
    """Return a shipped robot with its tool nests; raises UnknownRobotError."""
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
