"""The scene of a fit: the data as causes look at them."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.causes import Scene
from truepose.effects.names import joint_name
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import State, rows_of
from truepose.identification.problem.build import Problem


def scene_of(problem: Problem, fit: RobustFit) -> Scene:
    """Return the scene of a fitted problem."""
    fixed = [block.targets.stops.time_s for block in fit.blocks if block.table == "reference"]
    times = [time_s for time_s in fixed if time_s is not None]
    return scene_at(problem, fit.results[0].state, np.concatenate(times) if times else np.zeros(0))


def scene_at(problem: Problem, state: State, reference_s: FloatArray) -> Scene:
    """Return the scene of a model evaluated at its readings; fixed nests were read at `reference_s`, (r,)."""
    rows, structure = rows_of(state), state.structure
    spring = dict(zip(structure.names, state.values.tolist(), strict=True))
    x, y, z = structure.gravity_m_s2.tolist()
    return Scene(
        setting=problem.setting,
        stops=state.targets.stops,
        nest=state.targets.nest,
        chain=state.chain,
        torque_n_mm=rows.torque_n_mm,
        turn_rad=rows.turn_rad,
        softness_rad_per_n_mm=np.array([
            spring.get(joint_name("c", joint), 0.0) for joint in range(structure.robot.n_joints)
        ]),
        present=frozenset(structure.names),
        effects=structure.effects,
        reference_s=reference_s,
        origin_s=structure.origin_s,
        gravity_m_s2=(x, y, z),
        legs=problem.quantity == "length",
        initialisation=state.targets.initialisation,
        placement=state.targets.placement,
        instrument_mm=structure.instrument_mm,
    )
