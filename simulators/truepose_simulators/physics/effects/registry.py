"""The effects by the names that scenarios and identified models use: one line each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from truepose_simulators.errors import ModelError, ScenarioError
from truepose_simulators.physics.effects import (
    axis_parallelism,
    backlash,
    ballbar_zero,
    base_compliance,
    base_drift,
    base_shift,
    compliance,
    compliance_nonlinear,
    fixture_shift,
    instrument_drift,
    instrument_scale,
    joint_coupling,
    joint_gain,
    joint_harmonics,
    label_swap,
    link_bending,
    link_mass,
    nest_offset,
    outliers,
    payload,
    thermal_growth,
    tool_reseating,
)
from truepose_simulators.physics.effects.effect import IdentifiedEffect, ModelArm, PlantedChange, Site
from truepose_simulators.physics.effects.ports import Effect

LATEST_S = 1e9  # thirty years of cell time
Realise: TypeAlias = Callable[[IdentifiedEffect, ModelArm], tuple[Effect, ...]]


@dataclass(frozen=True, slots=True)
class Kind:
    """How an effect is built, and which amplitudes its small-motion physics stands."""

    plant: Callable[[PlantedChange, Site], Effect]
    lowest: float
    highest: float
    realise: Realise | None = None  # from the parameters of an identified model, where it is one of a robot


EFFECTS: Mapping[str, Kind] = MappingProxyType({
    "axis_parallelism": Kind(axis_parallelism.plant, -5.0, 5.0),
    "backlash": Kind(backlash.plant, 0.0, 5.0, backlash.realise),
    "ballbar_zero": Kind(ballbar_zero.plant, 0.0, 1.0),
    "base_compliance": Kind(base_compliance.plant, 0.0, 1e-6, base_compliance.realise),
    "base_drift": Kind(base_drift.plant, -100.0, 100.0, base_drift.realise),
    "base_shift": Kind(base_shift.plant, -100.0, 100.0, base_shift.realise),
    "compliance": Kind(compliance.plant, -5e-6, 5e-6, compliance.realise),
    "compliance_nonlinear": Kind(compliance_nonlinear.plant, -1.0, 10.0, compliance_nonlinear.realise),
    "fixture_shift": Kind(fixture_shift.plant, -100.0, 100.0),
    "instrument_drift": Kind(instrument_drift.plant, -100.0, 100.0, instrument_drift.realise),
    "instrument_scale": Kind(instrument_scale.plant, -0.01, 0.01, instrument_scale.realise),
    "joint_coupling": Kind(joint_coupling.plant, -0.1, 0.1, joint_coupling.realise),
    "joint_gain": Kind(joint_gain.plant, -0.1, 0.1, joint_gain.realise),
    "joint_harmonics": Kind(joint_harmonics.plant, -5.0, 5.0, joint_harmonics.realise),
    "label_swap": Kind(label_swap.plant, 0.0, 1.0),
    "link_bending": Kind(link_bending.plant, 0.0, 10.0, link_bending.realise),
    "link_mass": Kind(link_mass.plant, -20.0, 20.0, link_mass.realise),
    "nest_offset": Kind(nest_offset.plant, -100.0, 100.0, nest_offset.realise),
    "outliers": Kind(outliers.plant, 0.0, 1.0),
    "payload": Kind(payload.plant, -20.0, 20.0, payload.realise),
    "thermal_growth": Kind(thermal_growth.plant, -1e-3, 1e-3, thermal_growth.realise),
    "tool_reseating": Kind(tool_reseating.plant, 0.0, 10.0, tool_reseating.realise),
})

# How effects are built from the parameters of an identified model. Those that place the base, the links and
# the nests are the plant itself (`identified.py`); what a certificate allows is no change that is planted.
REALISED: Mapping[str, Realise] = MappingProxyType({
    "tool_certificate": nest_offset.realise_certificate,
    **{name: kind.realise for name, kind in EFFECTS.items() if kind.realise is not None},
})


def realise_effect(stated: IdentifiedEffect, site: ModelArm) -> tuple[Effect, ...]:
    """Build an effect as an identified model states it; raises ModelError where no physics is here for it."""
    realise = REALISED.get(stated.effect)
    if realise is None:
        raise ModelError(
            f"effect {stated.effect}: the simulator does not know this effect; known:"
            f" {', '.join(sorted(REALISED))}"
        )
    return realise(stated, site)


def plant_effect(change: PlantedChange, site: Site) -> Effect:
    """Build the effect of a planted change; raises ScenarioError, which says what would be right."""
    kind = EFFECTS.get(change.name)
    if kind is None:
        raise ScenarioError(f'unknown effect "{change.name}"; known: {", ".join(EFFECTS)}')
    if not kind.lowest <= change.amplitude <= kind.highest:
        raise ScenarioError(
            f"effect {change.name}: amplitude must be {kind.lowest:g} to {kind.highest:g}, not"
            f" {change.amplitude:g}"
        )
    if not abs(change.from_s) <= LATEST_S:
        raise ScenarioError(
            f"effect {change.name}: from_s must lie within {LATEST_S:g} s of the start, not {change.from_s:g}"
        )
    return kind.plant(change, site)
