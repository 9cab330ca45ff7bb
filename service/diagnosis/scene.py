"""The scene of a fit: the data as causes look at them."""

import numpy as np

from service.domain.campaign import Campaign
from service.effects.causes import Scene
from service.effects.names import joint_name
from service.identification.evaluation import rows_of
from service.identification.problem import Problem
from service.identification.reference import ReferenceBlock
from service.identification.robust import RobustFit


def scene_of(campaign: Campaign, problem: Problem, fit: RobustFit) -> Scene:
    """Return the scene of a fitted problem."""
    state = fit.results[0].state
    rows, structure = rows_of(state), fit.structure
    spring = dict(zip(structure.names, fit.values.tolist(), strict=True))
    fixed = [block.targets.stops.time_s for block in fit.blocks if isinstance(block, ReferenceBlock)]
    times = [time_s for time_s in fixed if time_s is not None]
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
        reference_s=np.concatenate(times) if times else np.zeros(0),
        origin_s=structure.origin_s,
        gravity_m_s2=campaign.gravity_m_s2,
        legs=problem.quantity == "length",
        initialisation=state.targets.initialisation,
        placement=state.targets.placement,
    )
