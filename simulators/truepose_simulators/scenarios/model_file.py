"""Model files of the service (`identify --model-out`, `diagnose --model-out`), as far as a robot is in them.

Read here on its own: covariances, priors and what the service keeps for itself are passed over, keys that
later versions add as well. Angles are in degrees there, rates of angles in rad or degrees per hour.
"""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from truepose_simulators.errors import ModelError, ScenarioError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.identified import IdentifiedModel
from truepose_simulators.physics.rigid import FloatArray, pose_matrix
from truepose_simulators.physics.table_arm import ArmTable, FrameMass, TableRow
from truepose_simulators.scenarios.table import convert, read_table, read_text

_FORMAT = "truepose-model"
_VERSION = 1
_RAD = math.radians(1.0)
_FACTORS = {
    **dict.fromkeys(("mm", "rad", "1", "kg", "kg*mm", "mm/h", "rad/h", "1/K", "rad/rad", "rad/K"), 1.0),
    **dict.fromkeys(("rad/(N*mm)", "rad*s2/m", "1/(N*mm2)", "mm/N"), 1.0),
    **dict.fromkeys(("deg", "deg/h", "deg/K"), _RAD),
}

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _Row:
    joint: int
    alpha_deg: float
    a_mm: float
    theta_offset_deg: float
    d_mm: float
    sign: int = 1
    beta_deg: float = 0.0


@dataclass(frozen=True, slots=True)
class _Mass:
    frame: int
    kg: float
    cog_mm: Vector


@dataclass(frozen=True, slots=True)
class _Placement:
    x_mm: float
    y_mm: float
    z_mm: float
    rx_deg: float
    ry_deg: float
    rz_deg: float


@dataclass(frozen=True, slots=True)
class _Nest:
    nest: int
    centre_mm: Vector


@dataclass(frozen=True, slots=True)
class _Parameter:
    name: str
    effect: str
    value: float
    unit: str


def load_model(path: Path) -> IdentifiedModel:
    """Read a model file; raises ModelError with file and key."""
    try:
        document = json.loads(read_text(path))
    except OSError as error:
        raise ModelError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:  # no JSON, no UTF-8, or nested without end
        raise ModelError(f"{path.name} is not a model file: it is cut off, or not JSON") from error
    try:
        return _read(document, path.name)
    except ScenarioError as error:  # the tables' own word for a value that cannot be meant
        raise ModelError(str(error)) from error


def _read(document: object, where: str) -> IdentifiedModel:
    if not isinstance(document, Mapping) or document.get("format") != _FORMAT:
        raise ModelError(f'{where} is not a model file; one begins with "format": "{_FORMAT}"')
    version = convert(int, _needed(document, "version", where), f'{where}: key "version"')
    if version > _VERSION:
        raise ModelError(
            f"{where} has version {version}, but this simulator reads up to {_VERSION}; update truepose"
        )
    _require_unedited(document, where)
    nests = [_table(_Nest, item, at) for at, item in _entries(document, "tool_nests", where)]
    if [nest.nest for nest in nests] != list(range(1, len(nests) + 1)) or not nests:
        raise ModelError(f'{where}: key "tool_nests" must list nests 1, 2, ... in order')
    return IdentifiedModel(
        table=_arm(_needed(document, "robot", where), f"{where}: robot"),
        gravity_m_s2=_value(Vector, document, "gravity_m_s2_world", where),
        base=_base(_table(_Placement, _needed(document, "base_in_world", where), f"{where}: base_in_world")),
        nests_mm=np.array([nest.centre_mm for nest in nests]),
        instrument_mm=_optional(Vector, document, "instrument_in_world_mm", where),
        parameters=_parameters(document, where),
        origin_s=_optional(float, document, "origin_s", where) or 0.0,
        sensed_torques=bool(_optional(bool, document, "torques_measured", where)),
        repeatability_mm=_optional(float, document, "repeatability_mm", where) or 0.0,
    )


def _require_unedited(document: Mapping[str, object], where: str) -> None:
    """Refuse a file whose digest is that of other values; one without a digest is taken as it is.

    The canonical form is that of `tests/vectors/model_digest.json`.
    """
    stated = document.get("digest")
    content = {key: _canonical(value) for key, value in document.items() if key != "digest"}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    if stated not in {None, f"sha256:{hashlib.sha256(text.encode()).hexdigest()}"}:
        raise ModelError(
            f"{where} was edited after truepose wrote it: its digest does not match its values; "
            'remove the key "digest" to simulate the file as it is'
        )


def _canonical(value: object) -> object:
    if isinstance(value, dict):
        return {key: _canonical(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_canonical(entry) for entry in value]
    # Programs write one number as 1 or as 1.0; the digest must not depend on which of them wrote last.
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _arm(robot: object, where: str) -> ArmTable:
    if not isinstance(robot, Mapping):
        raise ModelError(f"{where} must be a table of keys")
    rows = [_table(_Row, item, at) for at, item in _entries(robot, "dhm_nominal", where)]
    if [row.joint for row in rows] != list(range(1, len(rows) + 1)) or not rows:
        raise ModelError(f'{where}: key "dhm_nominal" must list joints 1, 2, ... in order')
    if any(row.sign not in {-1, 1} for row in rows):
        raise ModelError(f'{where}: key "sign" of a joint must be 1 or -1')
    tilted = [row.joint for row in rows if row.beta_deg]
    if tilted:
        raise ModelError(f"{where}: joint {tilted[0]} has a nominal beta; simulated arms have none")
    masses = [_table(_Mass, item, at) for at, item in _entries(robot, "masses", where)]
    if any(not 1 <= mass.frame <= len(rows) for mass in masses):
        raise ModelError(f'{where}: key "frame" of a mass must be 1 to {len(rows)}')
    return ArmTable(
        name=_value(str, robot, "name", where),
        rows=tuple(
            TableRow(r.alpha_deg * _RAD, r.a_mm, r.theta_offset_deg * _RAD, r.d_mm, r.sign) for r in rows
        ),
        masses=tuple(FrameMass(mass.frame, mass.kg, mass.cog_mm) for mass in masses),
        limits_rad=_ranges(robot, "joint_limits_deg", len(rows), where),
        calibration_rad=_ranges(robot, "calibration_ranges_deg", len(rows), where),
        gear_ratio=_per_joint(robot, "gear_ratio", len(rows), where),
        typical_compliance_rad_per_n_mm=_per_joint(robot, "typical_compliance_rad_per_Nmm", len(rows), where),
    )


def _base(place: _Placement) -> FloatArray:
    angles = np.radians([place.rx_deg, place.ry_deg, place.rz_deg])
    return pose_matrix(np.array([place.x_mm, place.y_mm, place.z_mm]), angles)


def _ranges(
    robot: Mapping[str, object], key: str, n: int, where: str
) -> tuple[tuple[float, float], ...] | None:
    pairs = _optional(tuple[tuple[float, float], ...], robot, key, where)
    if pairs is None:
        return None
    _check_count(pairs, key, n, where)
    return tuple((lower * _RAD, upper * _RAD) for lower, upper in pairs)


def _per_joint(robot: Mapping[str, object], key: str, n: int, where: str) -> tuple[float, ...] | None:
    values: tuple[float, ...] | None = _optional(tuple[float, ...], robot, key, where)
    if values is not None:
        _check_count(values, key, n, where)
    return values


def _check_count(values: tuple[object, ...], key: str, n: int, where: str) -> None:
    if len(values) != n:
        raise ModelError(f'{where}: key "{key}" must have {n} entries, one per joint, not {len(values)}')


def _parameters(document: Mapping[str, object], where: str) -> dict[str, dict[str, float]]:
    """Values by effect and name, in mm and rad; effects without any are there, and empty."""
    names = _value(tuple[str, ...], document, "effects", where)
    by_effect: dict[str, dict[str, float]] = {name: {} for name in names}
    for at, item in _entries(document, "parameters", where):
        parameter = _table(_Parameter, item, at)
        factor = _FACTORS.get(parameter.unit)
        if factor is None:
            raise ModelError(
                f'{at}: the unit "{parameter.unit}" of {parameter.name} is not one of {", ".join(_FACTORS)}'
            )
        by_effect.setdefault(parameter.effect, {})[parameter.name] = factor * parameter.value
    return by_effect


def _table(cls: type[T], table: object, where: str) -> T:
    """Read the keys that `cls` has; others, and those that are null, are passed over."""
    if not isinstance(table, Mapping):
        raise ModelError(f"{where} must be a table of keys")
    known = {field.name for field in fields(cls)}  # type: ignore[arg-type]
    present = {key: value for key, value in table.items() if key in known and value is not None}
    return read_table(cls, present, where)


def _entries(document: Mapping[str, object], key: str, where: str) -> list[tuple[str, object]]:
    listed = _needed(document, key, where)
    if not isinstance(listed, list):
        raise ModelError(f'{where}: key "{key}" must be a list')
    return [(f"{where}: {key} number {number}", item) for number, item in enumerate(listed, start=1)]


def _value(hint: Any, document: Mapping[str, object], key: str, where: str) -> Any:
    return convert(hint, _needed(document, key, where), f'{where}: key "{key}"')


def _optional(hint: Any, document: Mapping[str, object], key: str, where: str) -> Any:
    """Return a value, None where the key is absent or null."""
    value = document.get(key)
    return None if value is None else convert(hint, value, f'{where}: key "{key}"')


def _needed(document: Mapping[str, object], key: str, where: str) -> object:
    if document.get(key) is None:
        raise ModelError(f'{where}: key "{key}" is missing')
    return document[key]
