"""Keep-out volumes as they stand in a cell file under [limits], or in a file of their own (TOML or JSON).

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
"""

from pathlib import Path
from typing import Final

from truepose.domain.cell.keep_outs import Box, Cylinder, HalfSpace, KeepOut, KeepOuts, Vector, keep_outs_of
from truepose.exchange.cells.named import read_by_name
from truepose.exchange.document import Node, file_document

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
        node.fail(f"a keep-out volume has a name and is {_KINDS}; give all keys of one, no others")
    return HalfSpace(name, node.key("point_mm").vector(), _direction(node.key("outward")))


def _cylinder(node: Node, name: str) -> Cylinder:
    start, end = node.key("from_mm").vector(), node.key("to_mm").vector()
    if start == end:
        node.key("to_mm").fail("the cylinder ends where it begins; give it a length")
    return Cylinder(name, start, end, node.key("radius_mm").number(above=0.0))


def _interval(node: Node) -> tuple[float, float]:
    low, high = node.numbers(2)
    if low >= high:
        node.fail(f"ends at {high:g}, not above where it begins, {low:g}")
    return low, high


def _direction(node: Node) -> Vector:
    outward = node.vector()
    if not any(outward):
        node.fail("points nowhere; give the direction from the plane to the free side")
    return outward
