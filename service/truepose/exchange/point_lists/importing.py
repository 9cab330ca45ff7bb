"""A campaign of a list of points and a table of joints, and what has to be stated beside them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.domain.measurement.campaign import Campaign
from truepose.exchange.campaigns.arrays import campaign_from_arrays
from truepose.exchange.document import Node, file_document
from truepose.exchange.input_file import read_bytes
from truepose.exchange.point_lists.joined import AT_THE_END, Joined, joined
from truepose.exchange.point_lists.reading import UNITS_MM, Vector, read_point_list
from truepose.exchange.robots.campaign_keys import campaign_keys, named_robot

STATED: Final = "import.toml"  # where a folder of lists states it
_KEYS: Final = frozenset({"robot", "unit", "u_mm", "names", "nests_mm", "nest_u_mm"})


@dataclass(frozen=True, slots=True)
class Stated:
    """What neither file says."""

    robot: str  # shipped name, or a file
    unit: str | None = None  # of the points, a key of UNITS_MM; None: the list says it
    u_mm: float | None = None  # standard uncertainty per axis; None: the list says it
    names: str = AT_THE_END
    nests_mm: Sequence[Vector] = ()  # centres in the last frame; none: they are found
    nest_u_mm: float | None = None


def import_points(points: Path, joints: Path, stated: Stated) -> tuple[Campaign, Joined]:
    """Return the campaign, and what belongs to nothing; raises InputFileError, UnknownRobotError."""
    listed = read_point_list(points.name, read_bytes(points), stated.unit)
    found = joined(listed, joints.name, read_bytes(joints), names=stated.names, u_mm=stated.u_mm)
    described = {
        **campaign_keys(named_robot(stated.robot)),
        "tool_nests_mm": [list(centre) for centre in stated.nests_mm] or _unknown(found),
        "tool_nest_u_mm": stated.nest_u_mm,
        "base_in_world_nominal": None,
    }
    return campaign_from_arrays(described, {"calibration": {"nest": found.ones(), **found.columns}}), found


def _unknown(found: Joined) -> list[None]:
    """Return as many nests of unknown place as the readings name."""
    return [None] * int(max(found.columns.get("nest", found.ones())))


def read_stated(file: Path) -> Stated:
    """Read `import.toml`; a robot's file is looked for beside it. Raises InputFileError."""
    root = file_document(file)
    for unknown in root.unlisted(_KEYS):
        unknown.fail(f"the keys are {', '.join(sorted(_KEYS))}")
    unit, names = root.optional("unit"), root.optional("names")
    beside = file.parent / root.key("robot").text()
    return Stated(
        robot=str(beside) if beside.is_file() else root.key("robot").text(),
        unit=None if unit is None else _unit(unit),
        u_mm=_number(root.optional("u_mm")),
        names=AT_THE_END if names is None else names.text(),
        nests_mm=tuple(centre.vector() for centre in _items(root.optional("nests_mm"))),
        nest_u_mm=_number(root.optional("nest_u_mm")),
    )


def _unit(node: Node) -> str:
    if node.text() not in UNITS_MM:
        node.fail(f"must be one of {', '.join(UNITS_MM)}")
    return node.text()


def _number(node: Node | None) -> float | None:
    return None if node is None else node.number()


def _items(node: Node | None) -> Sequence[Node]:
    return () if node is None else node.items()
