"""Files of work volumes: a box in the world, ranges of the joints, or both; TOML, or JSON with these keys.

[box]                       # where a tool nest is, world frame
x_mm = [300.0, 600.0]
y_mm = [-200.0, 200.0]
z_mm = [100.0, 400.0]

[joints]
ranges_deg = [[-90, 90], [0, 60], [-80, 40], [-150, 150], [-90, 90], [-180, 180]]
"""

import math
from pathlib import Path

from truepose.domain.robot import JointRange
from truepose.exchange.document import Node, file_document
from truepose.exchange.errors import MissingEntryError
from truepose.planning.promise.volume import WorkVolume

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
        root.fail("a work volume is a [box], ranges of [joints], or both; give one", MissingEntryError)
    return WorkVolume(
        None if joints is None else _ranges(joints.key("ranges_deg"), n_joints),
        None if box is None else tuple(_interval(box.key(axis)) for axis in _AXES),
    )


def _ranges(node: Node, n_joints: int) -> tuple[JointRange, ...]:
    ends = (_interval(entry) for entry in node.items(n_joints))
    return tuple(JointRange(math.radians(low), math.radians(high)) for low, high in ends)


def _interval(node: Node) -> tuple[float, float]:
    low, high = node.numbers(2)
    if low > high:
        node.fail(f"ends at {high:g}, below where it begins, {low:g}")
    return low, high
