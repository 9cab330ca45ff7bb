"""What of a model is the same in every configuration: the table, base and tool that other programs can take.

A parameter belongs to it where it moves the table, the base, the tool or a nest by the same in every
configuration, whatever its effect is called. Springs, waves, backlash, drifts, what the instrument does to
lengths: all that is left out, and said.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Stops
from truepose.domain.results.identification import Model, NestCentre, Parameter
from truepose.domain.robot import FramePlacement, JointRow, Robot
from truepose.effects.ports import Port, PortKind, Term
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.model.evaluation import State, Targets, evaluate, nest_centres
from truepose.identification.model.parameters.counterparts import COUNTERPARTS
from truepose.identification.model.parameters.structure import base_axes
from truepose.kinematics.frames import angles_xyz, placement_of

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
    """The identified arm without anything that yields, wears, warms or drifts."""

    robot: Robot  # its table is the identified one
    base: FramePlacement  # in the world
    nests: tuple[NestCentre, ...]
    tool_rotation_rad: tuple[float, float, float]  # RotX RotY RotZ of the tool in the last frame
    uncertainty: tuple[Mapping[str, float], ...]  # standard, of each row by field [rad, mm], where known
    left_out: tuple[Parameter, ...]  # where lengths were read from is none of the robot's


def rigid_arm(model: Model) -> RigidArm:
    """Return the rigid part of a model; it is exact where nothing is left out."""
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
        nests=_nests(nest_centres(start, moved)[:-1]),
        tool_rotation_rad=angles_xyz(tool_rotation),
        uncertainty=_uncertainties(model, terms),
        left_out=tuple(
            parameter
            for k, parameter in enumerate(model.parameters)
            if k not in fixed and parameter.effect not in COUNTERPARTS
        ),
    )


def _anywhere(model: Model) -> State:
    """Return the model in the one configuration in which all joints read zero."""
    estimate = identified_estimate(model)
    # A model that knows no nest is looked at in the origin of its last frame.
    looked_at = np.vstack([estimate.structure.nests_mm, np.zeros(3)])
    structure = replace(estimate.structure, nests_mm=looked_at)
    zero = np.zeros((1, model.robot.n_joints))
    stops = Stops(np.array([1]), zero, torque_n_mm=zero if model.torques_measured else None)
    return evaluate(structure, estimate.values, Targets(stops, np.array([len(looked_at)])))


def _fixed(terms: Iterable[Term]) -> set[int]:
    """Return the parameters that only ever move rigid quantities, by the same everywhere."""
    acting, varying = set(), set()
    for term in terms:
        acting.add(term.parameter)
        if term.port.kind not in _RIGID or isinstance(term.weight, np.ndarray):
            varying.add(term.parameter)
    return acting - varying


def _moved(terms: Iterable[Term], values: FloatArray) -> dict[Port, FloatArray | float]:
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
        known[port.number][FIELDS[port.kind]] = float(np.sqrt(weight @ model.covariance @ weight))
    return tuple(known)
