"""Scenario files: TOML in, `Scenario` out.

`scenarios/irb120-tilted.toml` shows every key but those of the tables `probe`, `camera` and `loop`, which are
the fields of their dataclasses.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.cell.building import nominal_site
from truepose_simulators.cell.drawn_effects import CurveSizes, EverydaySizes
from truepose_simulators.cell.environment import AirSetup
from truepose_simulators.cell.fixture import HandsSetup
from truepose_simulators.cell.robot import TargetOutOfRangeError, check_range
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.file import read_fault
from truepose_simulators.faults.times import Fault
from truepose_simulators.instruments.accuracy import BallbarSetup, CameraSetup, ProbeSetup, TrackerSetup
from truepose_simulators.instruments.gauges.loop import LoopSetup
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.effects import PlantedChange, plant_effect
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.physics.true_robot import PlantSizes
from truepose_simulators.scenarios.scenario import (
    ArmSetup,
    ConfiguredLink,
    ConfiguredMotion,
    Scenario,
    TableSetup,
    ToolSetup,
)
from truepose_simulators.scenarios.table import convert, read_table, read_text

_SHIPPED = Path(__file__).parent
_TABLES: Mapping[str, type] = {
    "errors": PlantSizes,
    "base": ConfiguredMotion,
    "arm": ArmSetup,
    "tool": ToolSetup,
    "table": TableSetup,
    "tracker": TrackerSetup,
    "probe": ProbeSetup,
    "camera": CameraSetup,
    "ballbar": BallbarSetup,
    "loop": LoopSetup,
    "hands": HandsSetup,
    "air": AirSetup,
    "everyday": EverydaySizes,
    "curves": CurveSizes,
}
_CHANGE_KEYS = ("name", "subject", "amplitude", "from_s")
_LISTS = {"link": "links", "effect": "effects", "fault": "faults"}
_ADDED_UP = ("effect", "fault")
_PLAIN: Mapping[str, type] = {"robot": str, "noise": bool}


def shipped_scenarios() -> list[str]:
    """Names of the scenarios that come with the program."""
    return sorted(path.stem for path in _SHIPPED.glob("*.toml"))


def load_scenario(name: str) -> Scenario:
    """Read a scenario by its shipped name or from a file; raises ScenarioError with file and key."""
    path = _find(name)
    document = _merged(path, ())
    where = path.name
    _check_keys(document, where)
    robot = convert(str, _needed(document, "robot", where), f'{where}: key "robot"')
    if robot not in ARMS:
        raise ScenarioError(f'{where}: unknown robot "{robot}"; known: {", ".join(sorted(ARMS))}')
    values: dict[str, Any] = {
        key: convert(hint, document[key], f'{where}: key "{key}"')
        for key, hint in _PLAIN.items()
        if key in document
    }
    for key, cls in _TABLES.items():
        if key in document:
            values[key] = read_table(cls, document[key], f"{where}: [{key}]")
    arm = ARMS[robot]
    scenario = Scenario(
        name=path.stem,
        **values,
        links=tuple(_link(item, at, arm) for at, item in _entries(document, "link", where)),
        effects=tuple(read_change(item, at) for at, item in _entries(document, "effect", where)),
        faults=tuple(read_fault(item, at) for at, item in _entries(document, "fault", where)),
    )
    _check_home(scenario, arm, where)
    for number, fault in enumerate(scenario.faults, start=1):
        _check_fault(fault, scenario, f"{where}: [[fault]] number {number}")
    for number, change in enumerate(scenario.effects, start=1):
        _check_change(change, scenario, f"{where}: [[effect]] number {number}")
    return scenario


def read_change(table: object, where: str) -> PlantedChange:
    """Read a planted change: four keys of every effect, all others are details for the effect itself."""
    entries = table if isinstance(table, Mapping) else {}
    stated = {key: entries[key] for key in _CHANGE_KEYS if key in entries}
    change = read_table(PlantedChange, stated if isinstance(table, Mapping) else table, where)
    return replace(change, details={key: entries[key] for key in entries if key not in _CHANGE_KEYS})


def _check_home(scenario: Scenario, arm: Arm, where: str) -> None:
    home = scenario.arm.home_deg
    place = f'{where}: [arm]: key "home_deg"'
    if len(home) != arm.n_joints:
        raise ScenarioError(f"{place} must have {arm.n_joints} entries, not {len(home)}")
    try:
        check_range(arm, np.radians(home))
    except TargetOutOfRangeError as error:
        raise ScenarioError(f"{place}: {error}") from error


def _check_fault(fault: Fault, scenario: Scenario, where: str) -> None:
    try:
        scenario.check_fault(fault)
    except ScenarioError as error:
        raise ScenarioError(f"{where}: {error}") from error


def _find(name: str) -> Path:
    shipped = _SHIPPED / f"{name}.toml"
    if "/" not in name and shipped.is_file():
        return shipped
    path = Path(name)
    if path.is_file():
        return path
    known = ", ".join(shipped_scenarios())
    raise ScenarioError(f'no scenario "{name}": it is neither a file nor one of {known}')


def _merged(path: Path, children: tuple[Path, ...]) -> dict[str, Any]:
    """Read a file on top of the one it extends.

    Tables are taken key by key, effects and faults come after those of the other file, all else is taken as
    a whole.
    """
    document = _parse(path)
    parent = document.pop("extends", None)
    if parent is None:
        return document
    parent_path = _find(convert(str, parent, f'{path.name}: key "extends"'))
    if parent_path.resolve() in {child.resolve() for child in (*children, path)}:
        raise ScenarioError(f'{path.name}: key "extends" refers back to the file itself')
    result = _merged(parent_path, (*children, path))
    for key, value in document.items():
        before = result.get(key)
        if isinstance(value, dict) and isinstance(before, dict):
            result[key] = {**before, **value}
        elif key in _ADDED_UP and isinstance(value, list) and isinstance(before, list):
            result[key] = [*before, *value]
        else:
            result[key] = value
    return result


def _parse(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(read_text(path))
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path.name} cannot be read: {error}") from error
    except RecursionError as error:
        raise ScenarioError(f"{path.name} is not TOML: nested too deeply") from error
    except ValueError as error:  # also of a number of thousands of digits
        raise ScenarioError(f"{path.name} is not TOML: {error}") from error


def _check_keys(document: Mapping[str, object], where: str) -> None:
    known = [*_PLAIN, "extends", *_TABLES, *_LISTS]
    for key in document:
        if key not in known:
            raise ScenarioError(f'{where}: unknown key "{key}"; known: {", ".join(known)}')


def _needed(document: Mapping[str, object], key: str, where: str) -> object:
    if key not in document:
        raise ScenarioError(f'{where}: key "{key}" is missing')
    return document[key]


def _entries(document: Mapping[str, object], key: str, where: str) -> list[tuple[str, object]]:
    entries = document.get(key, [])
    if not isinstance(entries, list):
        raise ScenarioError(f"{where}: [[{key}]] must be a list of tables, written with double brackets")
    return [(f"{where}: [[{key}]] number {number}", entry) for number, entry in enumerate(entries, start=1)]


def _link(table: object, where: str, arm: Arm) -> ConfiguredLink:
    link = read_table(ConfiguredLink, table, where)
    if not 1 <= link.joint <= arm.n_joints:
        raise ScenarioError(f'{where}: key "joint" must be 1 to {arm.n_joints}, not {link.joint}')
    return link


def _check_change(change: PlantedChange, scenario: Scenario, where: str) -> None:
    try:
        plant_effect(change, nominal_site(scenario))
    except ScenarioError as error:
        raise ScenarioError(f"{where}: {error}") from error
