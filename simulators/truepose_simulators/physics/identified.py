"""A robot as an identified model describes it, realised by the physics of this package.

The model's parameters are taken at their word; what they do to the arm is computed here by rigid motions,
screws and forces, not by the program that identified them.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.effects import Effect, ModelArm, Stated, realise_effect
from truepose_simulators.physics.effects.base.base import placed_base
from truepose_simulators.physics.effects.joints.compliance import springs
from truepose_simulators.physics.effects.links.geometry import identified_links
from truepose_simulators.physics.effects.tool.tool import placed_nests
from truepose_simulators.physics.plant import Plant
from truepose_simulators.physics.rigid import FloatArray, to_six
from truepose_simulators.physics.table_arm import ArmTable, draw_arm, zero_frames

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
    nests_mm: FloatArray  # (m, 3) likewise, last frame
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
    nests_mm: FloatArray  # (m, 3) last frame


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


def _stated(model: IdentifiedModel, effect: str) -> Stated:
    return Stated(effect, model.parameters.get(effect, {}))
