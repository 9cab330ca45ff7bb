"""The parameter table: nominal and identified value of every parameter, and what it is."""

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from truepose.domain.measurement.campaign import Campaign
from truepose.domain.results.identification import Identification, Model, Parameter
from truepose.exchange.models.document import file_factor, file_unit
from truepose.identification.model.parameters.structure import base_axes
from truepose.identification.verdict.identifiability import UNDETERMINED
from truepose.kinematics.frames import (
    angles_xyz,
    placement_rotation,
    placement_translation,
    rotation_xyz,
)
from truepose.reports.parameters.meanings import meaning
from truepose.reports.wording.rounding import MISSING, exact, rounded, uncertainty
from truepose.words.catalogue import IN_ENGLISH, Catalogue

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


def model_rows(model: Model, words: Catalogue = IN_ENGLISH) -> tuple[tuple[str, str, str, str, str], ...]:
    """Return name, value, standard uncertainty, unit and meaning of every parameter of a model."""
    return tuple(_of_model(parameter, model, words) for parameter in model.parameters)


def _of_model(parameter: Parameter, model: Model, words: Catalogue) -> tuple[str, str, str, str, str]:
    factor, u = file_factor(parameter.unit), parameter.standard_uncertainty
    unit, said = file_unit(parameter.unit), meaning(parameter.name, parameter.effect, words)
    value = rounded(_identified(parameter, model) * factor, u * factor, unit)
    shown = words.units.conversion(unit).symbol
    return parameter.name, value, uncertainty(u * factor, unit), shown, said


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
        change=MISSING if nominal is None else rounded((identified - nominal) * factor, u, unit),
        identified=rounded(identified * factor, u, unit),
        standard_uncertainty=uncertainty(u, unit),
        unit=words.units.conversion(unit).symbol,
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
