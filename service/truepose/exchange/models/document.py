"""An identified model as the content of a JSON file, and back.

The file speaks degrees: every value whose internal unit is rad or rad/h, its standard uncertainty, prior
width and its rows and columns of the covariance are converted with it. The factor is applied to the floats in
full precision, so a model comes back within two roundings of each number.
"""

import math
from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results import Anchor, Model, NestCentre, Parameter, Unit
from truepose.exchange.document import Node
from truepose.exchange.errors import NewerVersionError, UnreadableFileError
from truepose.exchange.json_text import Json, number_or_null
from truepose.exchange.models.covariance import covariance_document, read_covariance
from truepose.exchange.robots.document import (
    placement_document,
    read_gravity,
    read_joints,
    read_placement,
    read_robot,
    robot_document,
)

FORMAT = "truepose-model"
VERSION = 1
_DEG = math.degrees(1.0)
_IN_DEGREES: Mapping[Unit, str] = {
    "rad": "deg",
    "rad/h": "deg/h",
    "rad/K": "deg/K",
}  # else the file speaks the internal unit
_INTERNAL_UNITS: tuple[Unit, ...] = get_args(Unit)
_UNITS: dict[str, Json] = {
    "length": "mm",
    "angle": "deg",
    "compliance": "rad/(N*mm)",
    "mass": "kg",
    "gravity": "m/s2",
    "covariance": "product of the units of its two parameters as listed under parameters, in their order",
}

Vector = tuple[float, float, float]


def file_unit(unit: Unit) -> str:
    """Return the unit that files and documents use for a quantity of an internal unit."""
    return _IN_DEGREES.get(unit, unit)


def file_factor(unit: Unit) -> float:
    """Return the factor from the internal unit to the unit of files and documents."""
    return _DEG if unit in _IN_DEGREES else 1.0


def model_document(model: Model) -> dict[str, Json]:
    """Return the content of a model file; NaN and infinity become null."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "program_version": model.program_version,
        "units": _UNITS,
        "identified_from": dict(model.identified_from),
        "robot": robot_document(model.robot),
        "gravity_m_s2_world": list(model.gravity_m_s2),
        "effects": list(model.effects),
        "base_in_world": placement_document(model.base),
        "tool_nests": _nests_document(model.nests),
        "tool_rotation_deg": _degrees(model.tool_rotation_rad),
        "instrument_in_world_mm": None if model.instrument_mm is None else list(model.instrument_mm),
        "repeatability_mm": number_or_null(model.repeatability_mm),
        "discrepancy_mm": number_or_null(model.discrepancy_mm),
        "torques_measured": model.torques_measured,
        "origin_s": model.origin_s,
        "nominal_fitted": _nominal_document(model),
        "parameters": [_parameter_document(parameter) for parameter in model.parameters],
        "covariance": _covariance_document(model),
    }


def _nominal_document(model: Model) -> dict[str, Json]:
    return {
        "base_in_world": placement_document(model.nominal_base),
        "tool_nests": _nests_document(model.nominal_nests),
        "tool_rotation_deg": _degrees(model.nominal_tool_rotation_rad),
        "leg_offset_mm": model.nominal_leg_offset_mm,
        "anchors": _anchors_document(model.nominal_anchors),
    }


def _nests_document(nests: Sequence[NestCentre]) -> Json:
    return [{"nest": nest.nest, "centre_mm": list(nest.centre_mm)} for nest in nests]


def _anchors_document(anchors: Sequence[Anchor]) -> Json:
    return [
        {"placement": anchor.placement, "base_point": anchor.base_point, "centre_mm": list(anchor.centre_mm)}
        for anchor in anchors
    ]


def _degrees(angles_rad: Vector) -> Json:
    return [math.degrees(angle) for angle in angles_rad]


def _parameter_document(parameter: Parameter) -> Json:
    factor = file_factor(parameter.unit)
    return {
        "name": parameter.name,
        "effect": parameter.effect,
        "value": parameter.value * factor,
        "unit": file_unit(parameter.unit),
        "standard_uncertainty": number_or_null(parameter.standard_uncertainty * factor),
        "prior_width": number_or_null(parameter.prior_width * factor),
    }


def _covariance_document(model: Model) -> Json:
    factors = np.array([file_factor(parameter.unit) for parameter in model.parameters])
    return covariance_document(model.covariance * np.outer(factors, factors))


def read_model_document(root: Node) -> Model:
    """Read the content of a model file; raises an InputFileError that names key and line."""
    _check_format(root)
    robot, nominal = root.key("robot"), root.key("nominal_fitted")
    parameters = tuple(_read_parameter(entry) for entry in root.key("parameters").items())
    return Model(
        robot=read_robot(robot, robot.key("name").text(), read_joints(robot.key("dhm_nominal"))),
        base=read_placement(root.key("base_in_world")),
        nests=_read_nests(root.key("tool_nests")),
        tool_rotation_rad=_read_rotation(root.key("tool_rotation_deg")),
        effects=tuple(entry.text() for entry in root.key("effects").items()),
        parameters=parameters,
        covariance=_read_covariance(root.key("covariance"), parameters),
        gravity_m_s2=read_gravity(root.key("gravity_m_s2_world")),
        discrepancy_mm=_number_or(root.key("discrepancy_mm"), math.nan),
        repeatability_mm=_number_or(root.key("repeatability_mm"), math.nan),
        nominal_base=read_placement(nominal.key("base_in_world")),
        nominal_nests=_read_nests(nominal.key("tool_nests")),
        nominal_tool_rotation_rad=_read_rotation(nominal.key("tool_rotation_deg")),
        instrument_mm=_read_instrument(root.key("instrument_in_world_mm")),
        torques_measured=root.key("torques_measured").truth(),
        origin_s=_read_origin_s(root.optional("origin_s")),
        nominal_leg_offset_mm=nominal.key("leg_offset_mm").number(),
        nominal_anchors=_read_anchors(nominal.key("anchors")),
        identified_from=_read_identified_from(root.key("identified_from")),
        program_version=_read_version(root.key("program_version")),
    )


def _check_format(root: Node) -> None:
    """Refuse what is no model, or one of a later program, before anything else is looked at."""
    if not isinstance(root.value, dict) or root.value.get("format") != FORMAT:
        root.fail(f'this is not a model file; one begins with "format": "{FORMAT}"', UnreadableFileError)
    version = root.key("version")
    number = version.whole(least=1)
    if number > VERSION:
        version.fail(
            f"the model file has version {number}, this program reads up to {VERSION}; update truepose",
            NewerVersionError,
        )


def _read_parameter(node: Node) -> Parameter:
    unit = _read_unit(node.key("unit"))
    factor = file_factor(unit)
    return Parameter(
        name=node.key("name").text(),
        effect=node.key("effect").text(),
        value=node.key("value").number() / factor,
        unit=unit,
        standard_uncertainty=_number_or(node.key("standard_uncertainty"), math.nan) / factor,
        prior_width=_number_or(node.key("prior_width"), math.inf) / factor,
    )


def _read_unit(node: Node) -> Unit:
    text = node.text()
    for unit in _INTERNAL_UNITS:
        if file_unit(unit) == text:
            return unit
    return node.fail(f"{text!r} is not a unit of this file; it must be one of {_listed_units()}")


def _listed_units() -> str:
    return ", ".join(file_unit(unit) for unit in _INTERNAL_UNITS)


def _read_covariance(node: Node, parameters: Sequence[Parameter]) -> FloatArray:
    factors = np.array([file_factor(parameter.unit) for parameter in parameters])
    scaled: FloatArray = read_covariance(node, len(parameters)) / np.outer(factors, factors)
    return scaled


def _number_or(node: Node, unknown: float) -> float:
    return unknown if node.is_null else node.number()


def _read_rotation(node: Node) -> Vector:
    x, y, z = node.vector()
    return (math.radians(x), math.radians(y), math.radians(z))


def _read_nests(node: Node) -> tuple[NestCentre, ...]:
    return tuple(NestCentre(e.key("nest").whole(least=1), e.key("centre_mm").vector()) for e in node.items())


def _read_anchors(node: Node) -> tuple[Anchor, ...]:
    return tuple(
        Anchor(e.key("placement").whole(), e.key("base_point").whole(), e.key("centre_mm").vector())
        for e in node.items()
    )


def _read_instrument(node: Node) -> Vector | None:
    return None if node.is_null else node.vector()


def _read_origin_s(node: Node | None) -> float:
    # Files from before there were drifts lack it; nothing in them counts from it.
    return 0.0 if node is None else node.number()


def _read_identified_from(node: Node) -> dict[str, str | int | float]:
    origin: dict[str, str | int | float] = {}
    for name, value in node.entries().items():
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            node.child(name, value).fail("text or a number is required")
        origin[name] = value
    return origin


def _read_version(node: Node) -> str:
    return "" if node.value == "" else node.text()
