"""Volumes in files: what the arm keeps out of, and the work volume; TOML, or JSON with these keys.

[[keep_out]]                # a box along the axes of the world
name = "conveyor"
x_mm = [400.0, 900.0]
y_mm = [250.0, 500.0]
z_mm = [0.0, 350.0]

[[keep_out]]                # a round bar
name = "lamp post"
from_mm = [300.0, -400.0, 0.0]
to_mm = [300.0, -400.0, 900.0]
radius_mm = 40.0

[[keep_out]]                # all behind a plane
name = "wall"
point_mm = [0.0, 600.0, 0.0]
outward = [0.0, -1.0, 0.0]

[box]                       # where a tool nest is, world frame
x_mm = [300.0, 600.0]
y_mm = [-200.0, 200.0]
z_mm = [100.0, 400.0]

[joints]
ranges_deg = [[-90, 90], [0, 60], [-80, 40], [-150, 150], [-90, 90], [-180, 180]]
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Final, Protocol, TypeVar

from truepose.domain.cell import Box, Cylinder, HalfSpace, KeepOut, KeepOuts, Vector, keep_outs_of
from truepose.domain.robot import JointRange
from truepose.exchange.document import Node, file_document
from truepose.exchange.errors import MissingEntryError
from truepose.planning.prediction.plan import WorkVolume


class _Named(Protocol):
    @property
    def name(self) -> str: ...


N = TypeVar("N", bound=_Named)


def read_by_name(node: Node, read: Callable[[Node], N], called: str) -> dict[str, N]:
    """Read the entries of a list, by name; raises InputFileError where two are called the same."""
    found: dict[str, N] = {}
    for entry in node.items():
        one = read(entry)
        if one.name in found:
            entry.key("name").fail(f"two {called} are called {one.name!r}; names must differ")
        found[one.name] = one
    return found


KEY: Final = "keep_out"
_BOX: Final = ("x_mm", "y_mm", "z_mm")
_CYLINDER: Final = ("from_mm", "to_mm", "radius_mm")
_HALF_SPACE: Final = ("point_mm", "outward")
_KINDS: Final = ", or ".join(
    f"{kind} ({', '.join(keys)})"
    for kind, keys in (("a box", _BOX), ("a cylinder", _CYLINDER), ("a half space", _HALF_SPACE))
)


def read_keep_out_file(path: Path) -> KeepOuts:
    """Read a file of keep-out volumes.

    Raises
    ------
    InputFileError
        With file and key.
    """
    root = file_document(path)
    for unknown in root.unlisted({KEY}):
        unknown.fail("a file of keep-out volumes has [[keep_out]] entries only")
    return read_keep_outs(root.key(KEY))


def read_keep_outs(node: Node) -> KeepOuts:
    """Read a list of keep-out volumes; their names differ."""
    return keep_outs_of(list(read_by_name(node, _read, "keep-out volumes").values()))


def _read(node: Node) -> KeepOut:
    given = set(node.entries()) - {"name"}
    name = node.key("name").text()
    if given == set(_BOX):
        x, y, z = (_interval(node.key(key)) for key in _BOX)
        return Box(name, (x[0], y[0], z[0]), (x[1], y[1], z[1]))
    if given == set(_CYLINDER):
        return _cylinder(node, name)
    if given != set(_HALF_SPACE):
        node.fail(f"a keep-out volume has a name and is {_KINDS}; give all keys of one kind, and no others")
    return HalfSpace(name, node.key("point_mm").vector(), _direction(node.key("outward")))


def _cylinder(node: Node, name: str) -> Cylinder:
    start, end = node.key("from_mm").vector(), node.key("to_mm").vector()
    if start == end:
        node.key("to_mm").fail("the cylinder ends where it begins; give it a length")
    return Cylinder(name, start, end, node.key("radius_mm").number(above=0.0))


def _interval(node: Node) -> tuple[float, float]:
    low, high = node.numbers(2)
    if low >= high:
        node.fail(f"the upper end {high:g} is not above the lower end {low:g}")
    return low, high


def _direction(node: Node) -> Vector:
    outward = node.vector()
    if not any(outward):
        node.fail("the vector is zero; give the direction from the plane to the free side")
    return outward


_KEYS = frozenset({"box", "joints"})
_AXES = ("x_mm", "y_mm", "z_mm")


def read_volume(path: Path, n_joints: int) -> WorkVolume:
    """Read a work volume for a robot of `n_joints`.

    Raises
    ------
    InputFileError
        With file and key.
    """
    root = file_document(path)
    for unknown in root.unlisted(_KEYS):
        unknown.fail("a work volume has `box` and `joints` only")
    box, joints = root.optional("box"), root.optional("joints")
    if box is None and joints is None:
        root.fail(
            "a work volume is a [box], ranges of [joints], or both; give at least one of them",
            MissingEntryError,
        )
    return WorkVolume(
        None if joints is None else _ranges(joints.key("ranges_deg"), n_joints),
        None if box is None else tuple(_interval_of_box(box.key(axis)) for axis in _AXES),
    )


def _ranges(node: Node, n_joints: int) -> tuple[JointRange, ...]:
    ends = (_interval_of_box(entry) for entry in node.items(n_joints))
    return tuple(JointRange(math.radians(low), math.radians(high)) for low, high in ends)


def _interval_of_box(node: Node) -> tuple[float, float]:
    low, high = node.numbers(2)
    if low > high:
        node.fail(f"the upper end {high:g} is below the lower end {low:g}")
    return low, high
