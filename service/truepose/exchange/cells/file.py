"""Cell files: TOML, described in docs/cell-file.md with an example; a cell by whatever name it is given."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Final

from truepose.domain.cell import Cell, CellLimits, Conditions, Detail, SimulatedCell
from truepose.domain.robot import FramePlacement, LinkMass, Nest, Robot
from truepose.exchange.cells.camera import before_camera
from truepose.exchange.cells.sections import (
    ARTEFACT,
    BALLBAR,
    CONDITIONS,
    FIXED_NEST,
    TOOL,
    certified_length,
    limits_of,
    read_devices,
    read_people,
    read_simulated,
    read_tracker,
    refuse_unlisted,
)
from truepose.exchange.document import TEXT, Form, Key, Node, each, read_bytes, read_keys, toml_document
from truepose.exchange.errors import MissingEntryError, UnknownRobotError
from truepose.exchange.robots.document import PLACEMENT, read_nest
from truepose.exchange.robots.named import (
    ENDINGS,
    RobotWithTool,
    is_robot_file,
    list_robots,
    load_robot_with_tool,
    read_robot_file,
)


def scenario_text(base: str, kind: str, tables: Iterable[Mapping[str, Detail]]) -> str:
    """Return a scenario that is `base` (shipped, or a file) with further tables of a kind, e.g. `effect`."""
    lines = [f"extends = {json.dumps(base)}"]
    for table in tables:
        lines += [
            f"[[{kind}]]",
            *(f"{json.dumps(key)} = {json.dumps(value)}" for key, value in table.items()),
        ]
    return "\n".join([*lines, ""])


_KEYS = frozenset({
    "name", "robot", "robot_serial_number", "base_in_world", "tool", "tool_nest", "world", "fixed_nest",
    "certified_length", "tracker", "limits", "conditions", "device", "simulated", "effect", "ballbar",
    "people", "camera",
})  # fmt: skip
_TABLE = frozenset({"world", "fixed_nest", "certified_length", "tracker", "camera"})
_CAMERA_SCENARIOS: Final = ("irb120-camera-spatial", "irb120-camera")  # each has a file; the longest first
_ROBOT_OF_SCENARIOS: Mapping[str, str] = {
    "irb120": "abb-irb-120",
    "lrmate": "fanuc-lr-mate-200ic",
    "ur10": "universal-robots-ur10",
    "kr6": "kuka-kr-6-r900-sixx",
}
_USUAL_TOOL_OF: Final = "abb-irb-120"
SCENARIO_PREFIXES: Final = tuple(_ROBOT_OF_SCENARIOS)  # that say which robot stands in a simulated cell


def read_cell(path: Path) -> Cell:
    """Read a cell file; a robot file that it names is looked for beside it.

    Raises
    ------
    InputFileError
        With file and key, and line where the text is not TOML at all.
    """
    root = toml_document(path.name, read_bytes(path))
    cell = _read(root if root.optional("simulated") is None else _completed(root), path.parent)
    if cell.simulated is None and not cell.devices:
        raise MissingEntryError(
            "the cell has neither devices nor a simulation; [[device]] entries or [simulated] is required",
            file=path.name,
        )
    return cell


def simulated_cell(scenario: str, seed: int) -> Cell:
    """Return the cell of a simulated scenario: the shipped table, tool and tracker.

    Parameters
    ----------
    scenario : str
        Shipped name, or a file whose name begins like one; `irb120...`, `lrmate...`, `ur10...` or `kr6...`
        says which robot.
    seed : int

    Raises
    ------
    UnknownRobotError
        The name does not say which robot stands in the cell.
    """
    robot = _robot_of_scenario(scenario)
    cell = _on_table(_template(scenario), robot)
    name = f"Simulated cell {Path(scenario).stem}"
    return replace(cell, name=name, simulated=SimulatedCell(scenario, seed))


def cell_on_usual_table(robot: str) -> Cell:
    """Return the cell of a robot with the table and tracker of simulated cells.

    A robot whose file describes no tool gets the triangular one.

    Parameters
    ----------
    robot : str
        Shipped name, or the path of a robot file.

    Raises
    ------
    InputFileError
        The robot file cannot be used, or no shipped robot has that name.
    """
    return _on_table(_template(), robot)


def _on_table(template: Node, robot: str) -> Cell:
    cell = _read(replace(template, value={**template.entries(), "robot": robot}), Path())
    return cell if cell.nests else replace(cell, nests=load_robot_with_tool(_USUAL_TOOL_OF).nests)


def _template(scenario: str = "") -> Node:
    """Return the table of a scenario: the usual one, or that before a camera."""
    usual, camera = _shipped_table("simulated.toml"), _camera_scenario(scenario)
    if camera is None:
        return usual
    before_camera = _shipped_table(f"{camera}.toml").entries()
    replaced = {key: entry for key, entry in usual.entries().items() if key not in _TABLE}
    return replace(usual, value={**replaced, **before_camera})


def _camera_scenario(scenario: str) -> str | None:
    name = Path(scenario).stem
    return next((known for known in _CAMERA_SCENARIOS if name.startswith(known)), None)


def reads_poses(scenario: str) -> bool:
    """Return whether a camera reads poses in a scenario, by its shipped name or file."""
    return _camera_scenario(scenario) is not None


def _shipped_table(name: str) -> Node:
    return toml_document(name, (files("truepose.exchange") / "cells" / name).read_bytes())


def _completed(root: Node) -> Node:
    """Return a simulated cell's file with what it leaves out: robot, table, tool and tracker are known."""
    own_table = not _TABLE.isdisjoint(root.entries())  # nests, tracker and paper of one table belong together
    scenario = root.key("simulated").optional("scenario")
    template = _template("" if scenario is None else scenario.text())
    shipped = {key: entry for key, entry in template.entries().items() if not (own_table and key in _TABLE)}
    if scenario is not None and "robot" not in root.entries():
        shipped["robot"] = _robot_of_scenario(scenario.text())
    return replace(root, value={**shipped, **root.entries()})


def _robot_of_scenario(scenario: str) -> str:
    for prefix, robot in _ROBOT_OF_SCENARIOS.items():
        if Path(scenario).name.startswith(prefix):
            return robot
    known = " or ".join(f"{prefix}..." for prefix in _ROBOT_OF_SCENARIOS)
    raise UnknownRobotError(
        f"Scenario {scenario!r} does not name the robot of the cell: begin its name with "
        f"{known}, or name robot and scenario in a cell file."
    )


_CELL: Final = (
    Key("name", "name", TEXT, absent=""),
    Key("robot", "robot_key", TEXT),
    Key("robot_serial_number", "robot_serial_number", TEXT, absent=""),
    Key("base_in_world", "base_nominal", PLACEMENT, absent=FramePlacement()),
    Key("tool", "tool", TOOL, absent=None),
    Key("fixed_nest", "fixed_nests", each(FIXED_NEST), absent=()),
    Key("world", "world", ARTEFACT, absent=None),
    Key("conditions", "conditions", CONDITIONS, absent=Conditions()),
    Key("device", "devices", Form(read_devices), absent=()),
    Key("ballbar", "ballbar", BALLBAR, absent=None),
    Key("people", "people", Form(read_people), absent=()),
)


def _read(root: Node, folder: Path) -> Cell:
    refuse_unlisted(root, _KEYS)
    shipped = _read_robot(root.key("robot"), folder)
    robot = _with_tool_mass(shipped.robot, root.optional("tool"))
    said = read_keys(root, [*_CELL, Key("limits", "limits", limits_of(robot), absent=CellLimits())])
    n_fixed_nests = len(said["fixed_nests"])
    lengths = each(certified_length(n_fixed_nests))
    cell = Cell(
        **{**said, "name": said["name"] or robot.name},
        **read_keys(root, [Key("certified_length", "certified_lengths", lengths, absent=())]),
        **read_tracker(root.optional("tracker"), n_fixed_nests),
        robot=robot,
        nests=_read_nests(root.optional("tool_nest"), shipped),
        simulated=read_simulated(root),
    )
    if cell.devices and cell.simulated is not None:
        root.key("simulated").fail("a cell is either simulated or has devices of its own; remove one")
    camera = root.optional("camera")
    return cell if camera is None else before_camera(cell, camera)


def _read_robot(node: Node, folder: Path) -> RobotWithTool:
    """Read the robot by its shipped name, or from a file beside the cell file."""
    name = node.text()
    if is_robot_file(name):
        return read_robot_file(folder / name)
    try:
        return load_robot_with_tool(name)
    except UnknownRobotError as error:
        node.fail(f"{str(error).removesuffix('.')}; or name a robot file ({', '.join(ENDINGS)})")


def _read_nests(node: Node | None, shipped: RobotWithTool) -> tuple[Nest, ...]:
    """Return the tool nests of the cell, else those of the tool that comes with the robot's masses."""
    if node is None:
        return shipped.nests
    return tuple(read_nest(entry) for entry in node.items())


def _with_tool_mass(robot: Robot, tool: Node | None) -> Robot:
    """Replace what the robot carries on its flange by the tool of this cell, where its mass is given."""
    if tool is None or tool.optional("mass_kg") is None:
        return robot
    mass, centre = tool.key("mass_kg").number(least=0.0), tool.key("cog_mm").vector()
    carried = LinkMass(robot.n_joints, mass, centre)
    # What a robot file has in the flange frame is the artefact that its masses came with; both would weigh.
    others = tuple(link for link in robot.masses if link.frame != robot.n_joints)
    return replace(robot, masses=(*others, carried))


_OF_ROBOTS = "dhm_nominal"  # a key that robot files have, and cell files have not


def cell_given(given: str) -> Cell:
    """Return the cell of a cell file (TOML), or that of a robot, its file or a scenario on the usual table.

    Raises
    ------
    UnknownRobotError
        It is neither a file nor a name that is known.
    InputFileError
        The file cannot be used.
    """
    path = Path(given)
    if path.suffix.lower() == ".toml":
        described = _OF_ROBOTS in toml_document(path.name, read_bytes(path)).entries()
        return cell_on_usual_table(given) if described else read_cell(path)
    if given in list_robots() or is_robot_file(given):
        return cell_on_usual_table(given)
    if given.startswith(SCENARIO_PREFIXES):
        return simulated_cell(given, 0)
    raise UnknownRobotError(
        f"{given!r} is not a campaign folder, cell file, robot file or robot name; the shipped robots are "
        f"{', '.join(list_robots())}."
    )
