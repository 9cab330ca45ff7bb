"""A robot as an identified model describes it, realised by the physics of this package.

The model's parameters are taken at their word; what they do to the arm is computed here by rigid motions,
screws and forces, not by the program that identified them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.effects import Effect, ModelArm, realise_effect
from truepose_simulators.physics.effects.compliance import springs
from truepose_simulators.physics.effects.effect import COMPONENTS, IdentifiedEffect
from truepose_simulators.physics.rigid import FloatArray, pose_matrix, to_six
from truepose_simulators.physics.table_arm import (
    ArmTable,
    RowErrors,
    TableRow,
    draw_arm,
    link_motion,
    zero_frames,
)
from truepose_simulators.physics.true_robot import Plant


def placed_base(start: FloatArray, stated: IdentifiedEffect) -> FloatArray:
    """Return the base in the world, shape (4, 4), from its start and `base_x`..`base_rz` [mm, rad].

    The identified angles turn the started orientation about the axes of the world, the identified shift moves
    the started origin; neither acts on the other.
    """
    six = np.zeros(6)
    for (component,), value in stated.matching(r"base_(r?[xyz])", "base_x to base_rz"):
        six[COMPONENTS.index(component)] = value
    base = pose_matrix(six[:3] + start[:3, 3], six[3:])
    base[:3, :3] = base[:3, :3] @ start[:3, :3]
    return base


_FIELDS = {"alpha": "alpha_rad", "a": "a_mm", "beta": "beta_rad", "theta": "theta_rad", "d": "d_mm"}
_FORM = "alpha_<joint>, a_, beta_, theta_, d_"


def identified_links(rows: Sequence[TableRow], stated: Sequence[IdentifiedEffect]) -> FloatArray:
    """Motions of all links in the seats of their joints, shape (J, 6) [mm, rad].

    Several effects may speak of one row, such as geometry and axis parallelism: their errors add up before
    the row is moved.
    """
    errors = [RowErrors()] * len(rows)
    for effect in stated:
        for (quantity, joint), value in effect.matching(r"(alpha|a|beta|theta|d)_([0-9]+)", _FORM):
            index, field = effect.index(joint, len(rows), "joint"), _FIELDS[quantity]
            errors[index] = replace(errors[index], **{field: getattr(errors[index], field) + value})
    return np.array([link_motion(row, error) for row, error in zip(rows, errors, strict=True)])


def placed_nests(start_mm: FloatArray, stated: IdentifiedEffect) -> FloatArray:
    """Nests in the flange frame, shape (m, 3), from their start and `nest_<nest>_x`.. [mm].

    `tool_rx`.. say how a measured orientation lies in the flange frame; they move no nest.
    """
    nests = start_mm.copy()
    form = "nest_<nest>_x, _y, _z, tool_rx, _ry, _rz"
    for (nest, axis), value in stated.matching(r"(?:nest_([0-9]+)_([xyz])|tool_r[xyz])", form):
        if nest is not None:
            nests[stated.index(nest, len(nests), "nest"), "xyz".index(axis)] += value
    return nests


_ROWS = frozenset({"geometry", "geometry_dhm", "joint_offset", "axis_parallelism"})
_PLACES = frozenset({"base", "tool"})
# Anchors, offset and zeros of a length gauge and motions of its fixture, what readings of fixed nests left
# open: how it was measured, not the robot.
_MEASURING = frozenset({"ballbar_zero", "fixture_shift", "legs", "reference"})


@dataclass(frozen=True)
class IdentifiedModel:
    """What a model file says of the robot and of how it was measured."""

    table: ArmTable
    gravity_m_s2: Vector  # world
    base: FloatArray  # (4, 4) where the identification started
    nests_mm: FloatArray  # (m, 3) likewise, flange frame
    instrument_mm: Vector | None  # world; None: not stated
    parameters: Mapping[str, Mapping[str, float]]  # by effect and name
    origin_s: float  # time of the campaign from which the effects' times count
    sensed_torques: bool  # the springs were identified from torque sensors
    repeatability_mm: float  # of the arm, per axis


@dataclass(frozen=True)
class IdentifiedRobot:
    """The model as a plant with effects."""

    plant: Plant
    effects: tuple[Effect, ...]
    nests_mm: FloatArray  # (m, 3) flange frame


def realise(model: IdentifiedModel) -> IdentifiedRobot:
    """Build the robot; raises ModelError for an effect or a parameter without physics."""
    rows, arm = model.table.rows, draw_arm(model.table)
    base = placed_base(model.base, _stated(model, "base"))
    links = identified_links(rows, [_stated(model, name) for name in model.parameters if name in _ROWS])
    motions = np.concatenate([to_six(base)[np.newaxis], links, np.zeros((1, 6))])
    nests_mm = placed_nests(model.nests_mm, _stated(model, "tool"))
    compliance = springs(_stated(model, "compliance"), arm.n_joints)
    site = ModelArm(arm, rows, zero_frames(rows), base, len(nests_mm), model.origin_s)
    plant = Plant(arm, motions, compliance, None, model.gravity_m_s2)
    return IdentifiedRobot(plant, tuple(_effects(model, site)), nests_mm)


def _effects(model: IdentifiedModel, site: ModelArm) -> Iterator[Effect]:
    for name in model.parameters:
        if name not in _ROWS | _PLACES | _MEASURING:
            yield from realise_effect(_stated(model, name), site)


def _stated(model: IdentifiedModel, effect: str) -> IdentifiedEffect:
    return IdentifiedEffect(effect, model.parameters.get(effect, {}))
