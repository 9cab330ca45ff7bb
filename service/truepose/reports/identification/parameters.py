"""The parameter table: nominal and identified value of every parameter, and what it is."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from truepose.domain.campaign import Campaign
from truepose.domain.identification import Identification, Model, Parameter
from truepose.exchange.models.document import file_factor, file_unit
from truepose.identification.model.structure import base_axes
from truepose.identification.verdict.identifiability import UNDETERMINED
from truepose.kinematics.frames import (
    angles_xyz,
    placement_rotation,
    placement_translation,
    rotation_xyz,
)
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Message, message
from truepose.reports.cause_words import printed_unit
from truepose.reports.rounding import MISSING, exact, format_rounded, uncertainty
from truepose.reports.tables import Table, heads_of

_MOTION = r"(r?[xyz])"
_MEANINGS = (
    (r"base_([xyz])", "parameters.base_place"),
    (r"base_r([xyz])", "parameters.base_orientation"),
    (r"alpha_(\d+)", "parameters.alpha"),
    (r"a_(\d+)", "parameters.a"),
    (r"theta_(\d+)", "parameters.theta"),
    (r"d_(\d+)", "parameters.d"),
    (r"beta_(\d+)", "parameters.beta"),
    (r"c_(\d+)", "parameters.compliance"),
    (r"c_(\d+)\*m([xy])_(\d+)", "parameters.compliance_product"),
    (r"soft_(\d+)_(\S+)", "parameters.soft"),
    (r"gain_(\d+)", "parameters.gain"),
    (r"wave_(\d+)_(\S+)_(sin|cos)", "parameters.wave"),
    (r"coupling_(\d+)_(\d+)", "parameters.coupling"),
    (r"gap_(\d+)", "parameters.gap"),
    (r"sag_(\d+)", "parameters.sag"),
    (r"payload_mass", "parameters.payload_mass"),
    (r"payload_([xyz])", "parameters.payload_moment"),
    (r"mass_(\d+)", "parameters.link_mass"),
    (r"moment_(\d+)_([xyz])", "parameters.link_moment"),
    (r"base_c", "parameters.base_compliance"),
    (r"growth", "parameters.growth"),
    (rf"drift_linear_{_MOTION}", "parameters.base_drift"),
    (rf"drift_exp([^_]+)_{_MOTION}", "parameters.base_settling"),
    (rf"tracker_linear_{_MOTION}", "parameters.tracker_drift"),
    (rf"tracker_exp([^_]+)_{_MOTION}", "parameters.tracker_settling"),
    (rf"jump_(\S+)_{_MOTION}", "parameters.base_jump"),
    (rf"fixture_(\d+)_(\S+)_{_MOTION}", "parameters.fixture_jump"),
    (rf"seat_(\d+)_{_MOTION}", "parameters.seat"),
    (r"offset_(\d+)_([xyz])", "parameters.offset"),
    (r"nest_(\d+)_([xyz])", "parameters.nest"),
    (r"tool_r([xyz])", "parameters.tool_orientation"),
    (r"anchor_(\d+)_(\d+)_([xyz])", "parameters.anchor"),
    (r"target_(\d+)_([xyz])", "parameters.target"),
    (r"target_(\d+)_zero", "parameters.target_zero"),
    (r"target_(\d+)_shift", "parameters.target_shift"),
    (r"target_(\d+)_slope([12])", "parameters.target_slope"),
    (r"fixed_(\d+)_([xyz])", "parameters.fixed"),
    (r"zero_(\d+)", "parameters.zero"),
    (r"zerorate_(\d+)_(\S+)", "parameters.zero_rate"),
    (r"cell_(\w+?)_.*", "parameters.cell"),
    (r"length_offset", "parameters.length_offset"),
    (r"(?:ballbar_)?scale", "parameters.scale"),
)
_GROUPS = ("first", "second", "third")


def meaning(name: str, effect: str, words: Catalogue = IN_ENGLISH) -> str:
    """Return what a parameter is, in words; the name of its effect where there is none."""
    for pattern, key in _MEANINGS:
        match = re.fullmatch(pattern, name)
        if match:
            groups = match.groups()
            told = dict(zip(_GROUPS, groups, strict=False))
            return words.say(key, before=_before(groups), about=_about(groups), **told)
    return effect


def _before(groups: tuple[str, ...]) -> int:
    """Return the number before the first, for axes that are named in pairs."""
    return int(groups[0]) - 1 if groups and groups[0].isdigit() else 0


def _about(groups: tuple[str, ...]) -> Message:
    """Return a component of a motion in words."""
    component = groups[-1] if groups else ""
    if component.startswith("r"):
        return message("parameters.about", axis=component[1:])
    return message("parameters.along", axis=component)


Standing = Literal["determined", "combination", "prior"]
_AXES = ("x", "y", "z")
_OF_THE_TABLE = {
    "alpha": "alpha_rad",
    "a": "a_mm",
    "beta": "beta_rad",
    "theta": "theta_offset_rad",
    "d": "d_mm",
}


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One parameter in the unit of documents, as text; angles in deg."""

    name: str
    effect: str
    nominal: str
    change: str
    identified: str
    standard_uncertainty: str
    unit: str
    prior_width: str
    meaning: str
    standing: Standing


def parameter_rows(
    identification: Identification, campaign: Campaign, words: Catalogue = IN_ENGLISH
) -> tuple[ParameterRow, ...]:
    """Return a row per parameter, in their order; none without a model."""
    model = identification.model
    if model is None:
        return ()
    together = _seen_together(identification)
    return tuple(
        _row(
            parameter,
            _nominal(parameter, model, campaign),
            _identified(parameter, model),
            parameter.name in together,
            words,
        )
        for parameter in identification.parameters
    )


def model_table(model: Model, words: Catalogue = IN_ENGLISH) -> Table:
    """Return what each parameter of a model is, its name, value, standard uncertainty and unit."""
    rows = (parameter_cells(one, _identified(one, model), words) for one in model.parameters)
    return parameter_table(rows, words)


def parameter_table(rows: Iterable[tuple[str, ...]], words: Catalogue) -> Table:
    """Return rows of `parameter_cells` under their heads."""
    heads = heads_of(words, "report.what_it_is", "report.parameter", "report.value", "u", "report.unit")
    return Table(heads, [*rows], names=2)


def parameter_cells(parameter: Parameter, value: float, words: Catalogue) -> tuple[str, ...]:
    """Return what a parameter is, its name, a value of it, its standard uncertainty and their unit."""
    factor, unit = file_factor(parameter.unit), file_unit(parameter.unit)
    u = parameter.standard_uncertainty * factor
    return (
        meaning(parameter.name, parameter.effect, words),
        parameter.name,
        format_rounded(value * factor, u, unit),
        uncertainty(u, unit),
        printed_unit(words.units.conversion(unit).symbol),
    )


def _seen_together(identification: Identification) -> set[str]:
    """Parameters of which the data leave a combination open; what never was a parameter is no such case."""
    names = {parameter.name for parameter in identification.parameters}
    return {
        name
        for group in identification.not_identifiable
        if names.issuperset(group.parameters)
        for name in group.parameters
    }


def _row(
    parameter: Parameter, nominal: float | None, identified: float, together: bool, words: Catalogue
) -> ParameterRow:
    factor = file_factor(parameter.unit)
    u, unit = parameter.standard_uncertainty * factor, file_unit(parameter.unit)

    return ParameterRow(
        name=parameter.name,
        effect=parameter.effect,
        nominal=MISSING if nominal is None else exact(nominal * factor, unit),
        change=MISSING if nominal is None else format_rounded((identified - nominal) * factor, u, unit),
        identified=format_rounded(identified * factor, u, unit),
        standard_uncertainty=uncertainty(u, unit),
        unit=printed_unit(words.units.conversion(unit).symbol),
        prior_width=words.units.conversion(unit).formatted(parameter.prior_width * factor, ".2g"),
        meaning=meaning(parameter.name, parameter.effect, words),
        standing=_standing(parameter, together),
    )


def _standing(parameter: Parameter, together: bool) -> Standing:
    if is_held_by_prior(parameter):
        return "prior"
    return "combination" if together else "determined"


def is_held_by_prior(parameter: Parameter) -> bool:
    """Whether the data say so little that the prior holds the parameter."""
    return parameter.standard_uncertainty > UNDETERMINED * parameter.prior_width


def _nominal(parameter: Parameter, model: Model, campaign: Campaign) -> float | None:
    """Nominal value in internal units; None where nobody states one."""
    kind, index = _split(parameter.name)
    if kind in _OF_THE_TABLE:
        return _stated(model, kind, index)
    if kind == "base":
        return None if campaign.base_nominal is None else _start(parameter.name, model)
    if kind in {"nest", "tool", "anchor", "target"} or parameter.name == "length_offset":
        return None
    return 0.0


def _stated(model: Model, kind: str, joint: int) -> float:
    """Return what the nominal table says of a joint."""
    value: float = getattr(model.robot.joints[joint - 1], _OF_THE_TABLE[kind])
    return value


def _identified(parameter: Parameter, model: Model) -> float:
    """Return the identified value in internal units: the start and what the parameter adds to it."""
    if re.fullmatch(r"(base|tool)_r[xyz]", parameter.name):
        return _turned(parameter.name, model)
    kind, index = _split(parameter.name)
    if kind in _OF_THE_TABLE:
        return _stated(model, kind, index) + parameter.value
    if kind in {"base", "nest"}:
        return _start(parameter.name, model) + parameter.value
    return parameter.value


def _start(name: str, model: Model) -> float:
    """Start value of a base or nest parameter."""
    if name.startswith("nest_"):
        _, number, axis = name.split("_")
        centre = next(nest.centre_mm for nest in model.nests if nest.nest == int(number))
        return centre[_AXES.index(axis)]
    component = name.removeprefix("base_")
    if component in _AXES:
        return float(placement_translation(model.base)[_AXES.index(component)])
    return angles_xyz(placement_rotation(model.base))[_AXES.index(component[1])]


def _turned(name: str, model: Model) -> float:
    """Angle of the identified rotation: the parameters turn before the start and do not simply add."""
    frame, component = name.split("_")
    value = {parameter.name: parameter.value for parameter in model.parameters}
    angles = np.array([value.get(f"{frame}_r{axis}", 0.0) for axis in _AXES])
    start = placement_rotation(model.base) if frame == "base" else rotation_xyz(*model.tool_rotation_rad)
    return angles_xyz(base_axes(start, angles)[0])[_AXES.index(component[1])]


def _split(name: str) -> tuple[str, int]:
    """Return quantity and number of e.g. `alpha_3`; 0 where there is no number at the end."""
    kind, _, number = name.partition("_")
    return kind, int(number) if number.isdigit() else 0
