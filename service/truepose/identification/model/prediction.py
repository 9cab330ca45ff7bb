"""Prediction with an identified model: positions, and how well they are known."""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import LegReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.last_moves import told_moves
from truepose.domain.results import Anchor, Model, NestCentre, Parameter
from truepose.effects.ports import ParameterSpec
from truepose.identification.model.beyond import held, held_variance
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.lengths import excess_mm, moved_feet
from truepose.identification.model.missing import left_out, left_out_variance, span_of
from truepose.identification.model.structure import Structure
from truepose.identification.observations.legs import LEG_OFFSET, anchor_name, leg_targets
from truepose.identification.problem.build import NOMINAL_EFFECTS
from truepose.kinematics.frames import placement_rotation, placement_translation, rotation_xyz


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


def predict(model: Model, stops: Stops, nest: IntArray) -> tuple[FloatArray, FloatArray]:
    """Predict nest positions.

    Parameters
    ----------
    model : Model
    stops : Stops
        n configurations.
    nest : ndarray, shape (n,)
        1-based.

    Returns
    -------
    position_mm : ndarray, shape (n, 3)
        World frame.
    standard_uncertainty_mm : ndarray, shape (n,)
        Per axis, root mean square of the three: covariance of the parameters, scatter of the arm, the
        discrepancy that held-out residuals showed, and of effects that a row does not tell enough about, or
        that nobody followed as far (`unpredictable`), what they usually do; not the noise of a reading.

    Raises
    ------
    ConfigurationError
        Another number of joints, an unknown nest, or measured torques that the model needs are missing.
    """
    _check(model, stops, nest)
    structure, values, targets = structure_of(model), values_of(model), Targets(told_moves(stops), nest)
    state = evaluate(structure, values, targets)
    jacobian = position_jacobian(state)
    variance = np.einsum("pni,pq,qni->n", jacobian, model.covariance, jacobian, optimize=True) / 3.0
    span = span_of(model.identified_from)
    missing = left_out_variance(structure, values, targets, state.position_mm, span)
    beyond = held_variance(structure, values, model.covariance, targets)
    total = variance + missing + beyond + model.repeatability_mm**2 + model.discrepancy_mm**2
    return state.position_mm, np.sqrt(total)


def unpredictable(model: Model, stops: Stops) -> tuple[str, ...]:
    """Return one sentence for every effect whose part in the positions of some rows is not known well."""
    return _unpredictable(model, Targets(told_moves(stops), np.ones(len(stops), dtype=np.int64)))


def unpredictable_lengths(model: Model, legs: LegReadings) -> tuple[str, ...]:
    """Return one sentence for every effect whose part in the lengths of some rows is not known well."""
    return _unpredictable(model, _leg_targets(legs))


def _unpredictable(model: Model, targets: Targets) -> tuple[str, ...]:
    structure = structure_of(model)
    return left_out(structure, targets) + held(structure, targets)


def predict_nominal(model: Model, stops: Stops, nest: IntArray) -> FloatArray:
    """Predict with the nominal model, base and unknown nests fitted, shape (n, 3) [mm]."""
    _check(model, stops, nest)
    structure = nominal_structure(model)
    return evaluate(structure, np.zeros(0), Targets(stops, nest)).position_mm


def nominal_structure(model: Model) -> Structure:
    """Return the nominal robot as fitted, with no parameters left."""
    return replace(
        structure_of(model),
        base_rotation=placement_rotation(model.nominal_base),
        base_origin_mm=placement_translation(model.nominal_base),
        nests_mm=_centres(model.nominal_nests),
        effects=tuple(name for name in model.effects if name in NOMINAL_EFFECTS),
        specs=(),
        owners=(),
        anchors=(),
    )


def _check(model: Model, stops: Stops, nest: IntArray) -> None:
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


def predict_lengths(model: Model, legs: LegReadings, *, nominal: bool = False) -> FloatArray:
    """Predict leg lengths between the model's anchors and its nests, shape (n,) [mm]."""
    _check(model, legs.stops, legs.nest)
    structure = nominal_structure(model) if nominal else structure_of(model)
    values = np.zeros(0) if nominal else values_of(model)
    offset = model.nominal_leg_offset_mm if nominal else _identified_offset(model)
    feet = _feet(model.nominal_anchors if nominal else identified_anchors(model), legs)
    state = evaluate(structure, values, _leg_targets(legs))
    arm = state.position_mm - moved_feet(state, feet)
    return np.asarray(np.linalg.norm(arm, axis=1) + offset + excess_mm(state))


def _leg_targets(legs: LegReadings) -> Targets:
    return leg_targets(replace(legs, stops=told_moves(legs.stops)))


def _feet(anchors: tuple[Anchor, ...], legs: LegReadings) -> FloatArray:
    """Return the anchor of each leg, shape (n, 3) [mm]."""
    places = {(anchor.placement, anchor.base_point): anchor.centre_mm for anchor in anchors}
    asked = list(zip(legs.placement.tolist(), legs.base_point.tolist(), strict=True))
    missing = sorted(set(asked) - set(places))
    if missing:
        raise ConfigurationError(
            f"Placement {missing[0][0]}, base point {missing[0][1]} was not among the legs "
            "that the model was made from."
        )
    return np.array([places[key] for key in asked])


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


def _identified_offset(model: Model) -> float:
    return next((p.value for p in model.parameters if p.name == LEG_OFFSET), 0.0)
