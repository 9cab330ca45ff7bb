"""Models with values: what was identified, and the nominal robot beside it."""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.results.identification import Anchor, Model, NestCentre, Parameter
from truepose.effects.ports import ParameterSpec
from truepose.identification.model.evaluation import Targets
from truepose.identification.model.parameters.anchors import LEG_OFFSET, LEG_OWNER, anchor_name
from truepose.identification.model.parameters.counterparts import TARGET_OWNER
from truepose.identification.model.parameters.structure import NOMINAL_EFFECTS, Structure
from truepose.identification.model.validity.missing import span_of
from truepose.kinematics.frames import placement_rotation, placement_translation, rotation_xyz


@dataclass(frozen=True, slots=True)
class Estimate:
    """A structure with values of its parameters, and how well these are known."""

    structure: Structure
    values: FloatArray  # (P,)
    covariance: FloatArray  # (P, P)


def identified_estimate(model: Model) -> Estimate:
    """Return what a model identified."""
    return Estimate(structure_of(model), values_of(model), model.covariance)


def nominal_estimate(model: Model) -> Estimate:
    """Return the nominal robot as fitted: of its parameters only those that legs need are left."""
    anchors = {(anchor.placement, anchor.base_point): anchor.centre_mm for anchor in model.nominal_anchors}
    fitted = {
        anchor_name(anchor, component): centre_mm[component]
        for anchor, centre_mm in anchors.items()
        for component in range(3)
    }
    if anchors:
        fitted[LEG_OFFSET] = model.nominal_leg_offset_mm
    targets = [p.name for p in model.parameters if p.effect == TARGET_OWNER]
    fitted |= dict(zip(targets, model.nominal_targets, strict=True))
    structure = replace(
        structure_of(model),
        base_rotation=placement_rotation(model.nominal_base),
        base_origin_mm=placement_translation(model.nominal_base),
        nests_mm=_centres(model.nominal_nests),
        tool_rotation=rotation_xyz(*model.nominal_tool_rotation_rad),
        effects=tuple(name for name in model.effects if name in NOMINAL_EFFECTS),
        specs=tuple(ParameterSpec(name, "mm", 0.0, 0.0) for name in fitted),
        owners=(LEG_OWNER,) * (len(fitted) - len(targets)) + (TARGET_OWNER,) * len(targets),
        anchors=tuple(anchors),
    )
    return Estimate(structure, np.array(list(fitted.values())), np.zeros((len(fitted), len(fitted))))


def structure_of(model: Model) -> Structure:
    """Return the structure whose parameters the model holds."""
    return Structure(
        robot=model.robot,
        base_rotation=placement_rotation(model.base),
        base_origin_mm=placement_translation(model.base),
        nests_mm=_centres(model.nests),
        tool_rotation=rotation_xyz(*model.tool_rotation_rad),
        gravity_m_s2=np.array(model.gravity_m_s2),
        effects=model.effects,
        specs=tuple(ParameterSpec(p.name, p.unit, 0.0, p.prior_width) for p in model.parameters),
        owners=tuple(p.effect for p in model.parameters),
        anchors=_anchors_of(model.parameters),
        targets=model.targets,
        instrument_mm=None if model.instrument_mm is None else np.array(model.instrument_mm),
        torques_measured=model.torques_measured,
        origin_s=model.origin_s,
        last_s=model.origin_s + span_of(model.identified_from).duration_s,
    )


def _centres(nests: tuple[NestCentre, ...]) -> FloatArray:
    return np.array([nest.centre_mm for nest in sorted(nests, key=lambda nest: nest.nest)]).reshape(-1, 3)


def _anchors_of(parameters: tuple[Parameter, ...]) -> tuple[tuple[int, int], ...]:
    found = [p.name.split("_") for p in parameters if p.name.startswith("anchor_") and p.name.endswith("_x")]
    return tuple((int(placement), int(point)) for _, placement, point, _ in found)


def values_of(model: Model) -> FloatArray:
    """Return the parameter values, shape (P,)."""
    return np.array([parameter.value for parameter in model.parameters])


def identified_anchors(model: Model) -> tuple[Anchor, ...]:
    """Return the base cups as identified."""
    value = {p.name: p.value for p in model.parameters}
    return tuple(
        Anchor(
            *anchor,
            (value[anchor_name(anchor, 0)], value[anchor_name(anchor, 1)], value[anchor_name(anchor, 2)]),
        )
        for anchor in _anchors_of(model.parameters)
    )


def check_targets(model: Model, targets: Targets) -> None:
    """Refuse targets that a model cannot predict; raises ConfigurationError."""
    stops, nest = targets.stops, targets.nest
    if stops.joints_rad.shape[1] != model.robot.n_joints:
        raise ConfigurationError(
            f"The model has {model.robot.n_joints} joints, the rows have {stops.joints_rad.shape[1]}."
        )
    if len(nest) and (nest.min() < 1 or nest.max() > len(model.nests)):
        raise ConfigurationError(
            f"Nest {int(nest.max()) if nest.max() > len(model.nests) else int(nest.min())} is unknown: "
            f"the model has nests 1 to {len(model.nests)}."
        )
    if model.torques_measured and (stops.torque_n_mm is None or not np.isfinite(stops.torque_n_mm).all()):
        raise ConfigurationError(
            "The model was identified with measured joint torques: give tau1_Nm.. of every row too."
        )
