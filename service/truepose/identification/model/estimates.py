"""Models with values: what was identified, the nominal robot beside it, and the arm of other programs.

Other programs take what is the same in every configuration: table, base and tool. A parameter belongs to it
where it moves the table, the base, the tool or a nest by the same in every configuration, whatever its effect
is called. Springs, waves, backlash, drifts, what the instrument does to lengths: all that is left out, and
said.

A quantity q of row i (alpha, a, beta, theta offset, d) of the rigid arm and its variance are

    q_i = nominal + w . p        u^2(q_i) = w^T C w

with p the parameters, C their covariance and w the weights of the terms that move q_i.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Anchor, Model, NestCentre, Parameter
from truepose.domain.robot import FramePlacement, JointRow, Robot
from truepose.effects.ports import ParameterSpec, Port, PortKind, Term
from truepose.identification.model.evaluation import State, Targets, evaluate, nest_centres
from truepose.identification.model.missing_input_uncertainty import span_of
from truepose.identification.model.structure import (
    COUNTERPARTS,
    LEG_OFFSET,
    LEG_OWNER,
    NOMINAL_EFFECTS,
    TARGET_OWNER,
    Structure,
    anchor_name,
    base_axes,
)
from truepose.kinematics.frames import (
    angles_xyz,
    placement_of,
    placement_rotation,
    placement_translation,
    rotation_xyz,
)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A structure with values of its parameters, and how well these are known.

    Attributes
    ----------
    structure : Structure
    values : ndarray, shape (P,)
        Internal units.
    covariance : ndarray, shape (P, P)
        Of the values.
    """

    structure: Structure
    values: FloatArray
    covariance: FloatArray


def identified_estimate(model: Model) -> Estimate:
    """Return what a model identified."""
    return Estimate(structure_of(model), values_of(model), model.covariance)


def nominal_estimate(model: Model) -> Estimate:
    """Return the nominal robot as fitted: of its parameters only those that legs and contacts need are left.

    Parameters
    ----------
    model : Model

    Returns
    -------
    Estimate
        Base and nests start where they were fitted around the nominal robot; anchors, offset and targets are
        its parameters. Its covariance is zero: how well a nominal robot is known is not asked.
    """
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
        # Priors of a model that is not fitted again are never asked for.
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
        # What drifted is held there.
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
    """Return the base cups as identified [mm, world frame]."""
    value = {p.name: p.value for p in model.parameters}
    return tuple(
        Anchor(
            *anchor,
            (value[anchor_name(anchor, 0)], value[anchor_name(anchor, 1)], value[anchor_name(anchor, 2)]),
        )
        for anchor in _anchors_of(model.parameters)
    )


def check_targets(model: Model, targets: Targets) -> None:
    """Refuse targets that a model cannot predict.

    Parameters
    ----------
    model : Model
    targets : Targets

    Raises
    ------
    ConfigurationError
        As of `check_stops` and `check_nests`.
    """
    check_stops(model, targets.stops)
    check_nests(model, targets.nest)


def check_stops(model: Model, stops: Stops) -> None:
    """Refuse stops at which a model cannot predict anything.

    Parameters
    ----------
    model : Model
    stops : Stops

    Raises
    ------
    ConfigurationError
        Another number of joints, or a row without the measured joint torques that the model was identified
        with.
    """
    if stops.joints_rad.shape[1] != model.robot.n_joints:
        raise ConfigurationError(
            f"The model has {model.robot.n_joints} joints, but the rows have {stops.joints_rad.shape[1]}."
        )
    if model.torques_measured and (stops.torque_n_mm is None or not np.isfinite(stops.torque_n_mm).all()):
        raise ConfigurationError(
            "The model was identified with measured joint torques. Give tau1_Nm.. for every row as well."
        )


def check_nests(model: Model, nest: IntArray) -> None:
    """Refuse nests that a model does not have.

    Parameters
    ----------
    model : Model
    nest : ndarray of int, shape (n,)
        From 1.

    Raises
    ------
    ConfigurationError
        With the number of one of them.
    """
    unknown = nest[(nest < 1) | (nest > len(model.nests))]
    if len(unknown):
        known = f"nests 1 to {len(model.nests)}" if model.nests else "no nests"
        raise ConfigurationError(f"Nest {int(unknown.max())} is unknown: the model has {known}.")


FIELDS: Final[Mapping[PortKind, str]] = {
    PortKind.ALPHA: "alpha_rad",
    PortKind.A: "a_mm",
    PortKind.BETA: "beta_rad",
    PortKind.THETA: "theta_offset_rad",
    PortKind.D: "d_mm",
}
_RIGID: Final = {*FIELDS, PortKind.BASE, PortKind.NEST, PortKind.TOOL_ROTATION}


@dataclass(frozen=True, slots=True)
class RigidArm:
    """The identified arm without anything that yields, wears, warms or drifts.

    Attributes
    ----------
    robot : Robot
        Its table is the identified one [rad, mm].
    base : FramePlacement
        In the world.
    nests : tuple of NestCentre
        [mm], flange frame.
    tool_rotation_rad : tuple of float, length 3
        RotX RotY RotZ of the tool in the flange frame.
    uncertainty : tuple of mapping, length J
        Standard uncertainty of each row by field [rad, mm], where a parameter moves it.
    left_out : tuple of Parameter
        What the arm does not contain; where lengths were read from is none of the robot's, and not among
        them.
    """

    robot: Robot
    base: FramePlacement
    nests: tuple[NestCentre, ...]
    tool_rotation_rad: tuple[float, float, float]
    uncertainty: tuple[Mapping[str, float], ...]
    left_out: tuple[Parameter, ...]


def rigid_arm(model: Model) -> RigidArm:
    """Return the rigid part of a model; it is exact where nothing is left out.

    Parameters
    ----------
    model : Model

    Returns
    -------
    RigidArm
    """
    state = _anywhere(model)
    fixed = _fixed(state.terms)
    terms = [term for term in state.terms if term.parameter in fixed]
    moved = _moved(terms, state.values)
    start = state.structure
    base_rotation, _ = base_axes(start.base_rotation, _three(moved, PortKind.BASE, 3))
    tool_rotation, _ = base_axes(start.tool_rotation, _three(moved, PortKind.TOOL_ROTATION, 0))
    return RigidArm(
        robot=replace(model.robot, joints=_rows(model.robot, moved)),
        base=placement_of(base_rotation, start.base_origin_mm + _three(moved, PortKind.BASE, 0)),
        # Without the origin of the flange frame, which was only looked at.
        nests=_nests(nest_centres(start, moved)[:-1]),
        tool_rotation_rad=angles_xyz(tool_rotation),
        uncertainty=_uncertainties(model, terms),
        # Cups and targets belong to what lengths were read against: an arm is complete without them.
        left_out=tuple(
            parameter
            for k, parameter in enumerate(model.parameters)
            if k not in fixed and parameter.effect not in COUNTERPARTS
        ),
    )


def _anywhere(model: Model) -> State:
    """Return the model in the one configuration in which all joints read zero."""
    estimate = identified_estimate(model)
    # A model that knows no nest is looked at in the origin of its flange frame.
    looked_at = np.vstack([estimate.structure.nests_mm, np.zeros(3)])
    structure = replace(estimate.structure, nests_mm=looked_at)
    # One configuration is enough: a weight that varies is an array, of however few rows.
    zero = np.zeros((1, model.robot.n_joints))
    stops = Stops(np.array([1]), zero, torque_n_mm=zero if model.torques_measured else None)
    return evaluate(structure, estimate.values, Targets(stops, np.array([len(looked_at)])))


def _fixed(terms: Iterable[Term]) -> set[int]:
    """Return the parameters that only ever move rigid quantities, by the same everywhere."""
    # A parameter that moves a rigid quantity and something else besides is taken whole or not at all.
    acting, varying = set(), set()
    for term in terms:
        acting.add(term.parameter)
        if term.port.kind not in _RIGID or isinstance(term.weight, np.ndarray):
            varying.add(term.parameter)
    return acting - varying


def _moved(terms: Iterable[Term], values: FloatArray) -> dict[Port, FloatArray | float]:
    # One port may be moved by several parameters: an error of the table and the zero of a joint.
    moved: defaultdict[Port, FloatArray | float] = defaultdict(float)
    for term in terms:
        moved[term.port] += term.weight * float(values[term.parameter])
    return dict(moved)


def _three(moved: Mapping[Port, FloatArray | float], kind: PortKind, first: int) -> FloatArray:
    return np.array([moved.get(Port(kind, first + k), 0.0) for k in range(3)], dtype=float)


def _rows(robot: Robot, moved: Mapping[Port, FloatArray | float]) -> tuple[JointRow, ...]:
    shifts = {(port.number, FIELDS[port.kind]): by for port, by in moved.items() if port.kind in FIELDS}
    return tuple(_shifted(row, number, shifts) for number, row in enumerate(robot.joints))


def _shifted(row: JointRow, number: int, shifts: Mapping[tuple[int, str], FloatArray | float]) -> JointRow:
    alpha, a, beta, theta, d = (
        float(getattr(row, field) + shifts.get((number, field), 0.0)) for field in FIELDS.values()
    )
    # A row has beta last, as tables that know none leave it out.
    return JointRow(alpha, a, theta, d, row.sign, beta)


def _nests(centres_mm: FloatArray) -> tuple[NestCentre, ...]:
    return tuple(
        NestCentre(number, (float(x), float(y), float(z)))
        for number, (x, y, z) in enumerate(centres_mm, start=1)
    )


def _uncertainties(model: Model, terms: Iterable[Term]) -> tuple[Mapping[str, float], ...]:
    """Return what is known of each row's quantities: of a sum of parameters with their correlations."""
    weights: defaultdict[Port, FloatArray] = defaultdict(lambda: np.zeros(len(model.parameters)))
    for term in terms:
        if term.port.kind in FIELDS:
            weights[term.port][term.parameter] += float(term.weight)
    known: list[dict[str, float]] = [{} for _ in model.robot.joints]
    for port, weight in weights.items():
        # A covariance written with few digits may be a little negative along a direction.
        variance = np.maximum(weight @ model.covariance @ weight, 0.0)
        known[port.number][FIELDS[port.kind]] = float(np.sqrt(variance))
    return tuple(known)
