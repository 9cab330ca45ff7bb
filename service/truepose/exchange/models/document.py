"""An identified model as the content of a JSON file, and back.

The file speaks degrees: every value whose internal unit is rad or rad/h, its standard uncertainty, prior
width and its rows and columns of the covariance are converted with it. The factor is applied to the floats in
full precision, so a model comes back within two roundings of each number.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final, get_args

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.contacts import Target, TargetKind
from truepose.domain.identification import (
    Anchor,
    MeasuredZone,
    Model,
    ModelInadequacy,
    NestCentre,
    Parameter,
    Unit,
)
from truepose.domain.robot import JointRange, Robot
from truepose.exchange.document import (
    NUMBER,
    TEXT,
    TRUTH,
    UNKNOWN_OR_NUMBER,
    VECTOR,
    Form,
    Key,
    Node,
    each,
    number,
    or_null,
    read_keys,
    record,
    whole,
    word,
    written_keys,
)
from truepose.exchange.errors import NewerVersionError, UnreadableFileError
from truepose.exchange.json_text import Json, number_or_null
from truepose.exchange.models.digest import KEY as DIGEST
from truepose.exchange.models.digest import digest_of
from truepose.exchange.robots.document import GRAVITY, PLACEMENT, ROBOT, covariance_document, read_covariance
from truepose.identification.model.validity import DIRECTIONS

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


def file_unit(unit: Unit) -> str:
    """Return the unit that files and documents use for a quantity of an internal unit."""
    return _IN_DEGREES.get(unit, unit)


def file_factor(unit: Unit) -> float:
    """Return the factor from the internal unit to the unit of files and documents."""
    return _DEG if unit in _IN_DEGREES else 1.0


def _read_identified_from(node: Node) -> dict[str, str | int | float]:
    origin: dict[str, str | int | float] = {}
    for name, value in node.entries().items():
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            node.child(name, value).fail("text or a number is required")
        origin[name] = value
    return origin


def _read_version(node: Node) -> str:
    return "" if node.value == "" else node.text()


_PLACE: Final = Key("centre_mm", "centre_mm", VECTOR)
_NESTS: Final = each(record(NestCentre, [Key("nest", "nest", whole(least=1)), _PLACE]))
_ANCHORS: Final = each(
    record(Anchor, [*(Key(name, name, whole()) for name in ("placement", "base_point")), _PLACE])
)
_TARGETS: Final = each(
    record(
        Target,
        [
            Key("target", "number", whole(least=1)),
            Key("kind", "kind", word(TargetKind)),
            Key("zero_mm", "zero_mm", NUMBER, absent=None),
            Key("u_zero_mm", "zero_uncertainty_mm", number(least=0.0)),
            Key("form_mm", "form_mm", number(least=0.0)),
            Key("place_mm", "place_mm", VECTOR, absent=None),
            Key("normal", "normal", VECTOR, absent=None),
        ],
    )
)
_ROTATION: Final = Form(
    lambda node: tuple(math.radians(angle) for angle in node.vector()),
    lambda angles_rad: [math.degrees(angle) for angle in angles_rad],
)


def _read_span(node: Node) -> JointRange:
    lower, upper = node.numbers(2)
    if lower > upper:  # of a joint that stood still they are the same
        node.fail(f"the lower end {lower:g} is above the upper end {upper:g}")
    return JointRange(*np.radians([lower, upper]).tolist())


_SPAN: Final = Form(
    _read_span,
    lambda span: [math.degrees(span.lower_rad), math.degrees(span.upper_rad)],
)
_ZONE: Final = record(
    MeasuredZone,
    [
        Key("joint_ranges_deg", "joint_ranges", each(_SPAN)),
        Key("flange_extents_mm", "extents_mm", each(NUMBER, len(DIRECTIONS))),
    ],
)
_ORIGIN: Final = [
    Key("program_version", "program_version", Form(_read_version)),
    Key("identified_from", "identified_from", Form(_read_identified_from, dict)),
]
_MODEL: Final = [
    Key("robot", "robot", ROBOT),
    Key("gravity_m_s2_world", "gravity_m_s2", GRAVITY),
    Key("effects", "effects", each(TEXT)),
    Key("base_in_world", "base", PLACEMENT),
    Key("tool_nests", "nests", _NESTS),
    Key("tool_rotation_deg", "tool_rotation_rad", _ROTATION),
    Key("instrument_in_world_mm", "instrument_mm", or_null(VECTOR)),
    Key("repeatability_mm", "repeatability_mm", UNKNOWN_OR_NUMBER),
    Key("discrepancy_mm", "discrepancy_mm", UNKNOWN_OR_NUMBER),
    Key("torques_measured", "torques_measured", TRUTH),
    # Files from before there were drifts lack it; nothing in them counts from it.
    Key("origin_s", "origin_s", NUMBER, absent=0.0),
    Key("targets", "targets", _TARGETS, absent=()),
    # Files from before targets were corrected lack it: nobody says where they extrapolate.
    Key("measured_zone", "zone", _ZONE, absent=None),
]
_NOMINAL: Final = [
    Key("base_in_world", "nominal_base", PLACEMENT),
    Key("tool_nests", "nominal_nests", _NESTS),
    Key("tool_rotation_deg", "nominal_tool_rotation_rad", _ROTATION),
    Key("leg_offset_mm", "nominal_leg_offset_mm", NUMBER),
    Key("anchors", "nominal_anchors", _ANCHORS),
    Key("targets", "nominal_targets", each(NUMBER), absent=()),
]


def model_document(model: Model) -> dict[str, Json]:
    """Return the content of a model file with its digest; NaN and infinity become null."""
    content = _content(model)
    return content | {DIGEST: digest_of(content)}


def _content(model: Model) -> dict[str, Json]:
    origin = written_keys(model, _ORIGIN)
    return {
        "format": FORMAT,
        "version": VERSION,
        "program_version": origin["program_version"],
        "units": _UNITS,
        "identified_from": origin["identified_from"],
        **written_keys(model, _MODEL),
        "nominal_fitted": written_keys(model, _NOMINAL),
        "parameters": [_parameter_document(parameter) for parameter in model.parameters],
        "covariance": _covariance_document(model.covariance, model.parameters),
        "shortfall": _shortfall_document(model.shortfall, model.parameters),
    }


def in_file_units(parameter: Parameter) -> dict[str, str | float]:
    """Return the fields of a parameter, in the unit that files use and that it then names."""
    factor = file_factor(parameter.unit)
    return {
        "name": parameter.name,
        "effect": parameter.effect,
        "value": parameter.value * factor,
        "unit": file_unit(parameter.unit),
        "standard_uncertainty": parameter.standard_uncertainty * factor,
        "prior_width": parameter.prior_width * factor,
    }


def _parameter_document(parameter: Parameter) -> Json:
    fields = in_file_units(parameter)
    return {key: it if isinstance(it, str) else number_or_null(it) for key, it in fields.items()}


def _factors(parameters: Sequence[Parameter]) -> FloatArray:
    return np.array([file_factor(parameter.unit) for parameter in parameters])


def _covariance_document(covariance: FloatArray, parameters: Sequence[Parameter]) -> Json:
    factors = _factors(parameters)
    return covariance_document(covariance * np.outer(factors, factors))


def _shortfall_document(short: ModelInadequacy | None, parameters: Sequence[Parameter]) -> Json:
    if short is None:
        return None
    absorbed = short.absorbed * np.divide.outer(_factors(parameters), _factors(short.functions))
    return {
        "functions": [_parameter_document(function) for function in short.functions],
        "covariance": _covariance_document(short.covariance, short.functions),
        "absorbed": [[number_or_null(entry) for entry in row] for row in absorbed.tolist()],
        "rest_mm": number_or_null(short.rest_mm),
    }


def read_model_document(root: Node) -> Model:
    """Read the content of a model file; raises an InputFileError that names key and line."""
    check_format(root)
    parameters = tuple(_read_parameter(entry) for entry in root.key("parameters").items())
    fields = read_keys(root, [*_ORIGIN, *_MODEL])
    _check_zone(root, fields["zone"], fields["robot"])
    return Model(
        **fields,
        **read_keys(root.key("nominal_fitted"), _NOMINAL),
        parameters=parameters,
        covariance=_read_covariance(root.key("covariance"), parameters),
        shortfall=_read_shortfall(root, parameters),
    )


NOT_A_MODEL: Final = f'this is not a model file; a model file begins with "format": "{FORMAT}"'


def check_format(root: Node) -> None:
    """Refuse what is no model, or one of a later program, before anything else is looked at."""
    if not isinstance(root.value, dict) or root.value.get("format") != FORMAT:
        root.fail(NOT_A_MODEL, UnreadableFileError)
    version = root.key("version")
    number = version.whole(least=1)
    if number > VERSION:
        version.fail(
            f"the model file has version {number}, this program reads up to {VERSION}; update truepose",
            NewerVersionError,
        )


def _check_zone(root: Node, zone: MeasuredZone | None, robot: Robot) -> None:
    if zone is not None and len(zone.joint_ranges) != robot.n_joints:
        root.key("measured_zone").fail(
            f"{len(zone.joint_ranges)} ranges are given for the {robot.n_joints} joints of the robot"
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
    factors = _factors(parameters)
    scaled: FloatArray = read_covariance(node, len(parameters)) / np.outer(factors, factors)
    return scaled


def _read_shortfall(root: Node, parameters: Sequence[Parameter]) -> ModelInadequacy | None:
    """Files from before models said where they fall short lack it."""
    node = root.optional("shortfall")
    if node is None:
        return None
    functions = tuple(_read_parameter(entry) for entry in node.key("functions").items())
    rows = [row.numbers(len(functions)) for row in node.key("absorbed").items(len(parameters))]
    absorbed = np.array(rows, float).reshape(len(parameters), len(functions))
    return ModelInadequacy(
        functions=functions,
        covariance=_read_covariance(node.key("covariance"), functions),
        absorbed=absorbed / np.divide.outer(_factors(parameters), _factors(functions)),
        rest_mm=node.key("rest_mm").number(),
    )


def _number_or(node: Node, unknown: float) -> float:
    return unknown if node.is_null else node.number()
