"""From a scenario and a seed to the true parts of a cell."""

from collections.abc import Sequence

import numpy as np

from simulators.everyday import draw_everyday
from simulators.physics.arm import CarriedMass
from simulators.physics.effects import Site
from simulators.physics.plant import Plant, draw_compliances, draw_motions
from simulators.physics.rigid import FloatArray
from simulators.physics.robots import ARMS
from simulators.planted import PlantedEffects
from simulators.scenario import Scenario


def draw_plant(scenario: Scenario, rng: np.random.Generator) -> Plant:
    """Draw the robot's errors, then put the stated ones in their place."""
    arm = ARMS[scenario.robot]
    motions = draw_motions(arm, scenario.errors, rng)
    compliance = draw_compliances(arm, scenario.errors, rng)
    if scenario.base is not None:
        motions[0] = [*scenario.base.translation_mm, *scenario.base.rotation_rad]
    for link in scenario.links:
        motions[link.joint] = [*link.translation_mm, *link.rotation_rad]
        if link.compliance_rad_per_n_mm is not None:
            compliance[link.joint - 1] = link.compliance_rad_per_n_mm
    return Plant(arm, motions, compliance, _tool_mass(scenario))


def draw_nests(nests_mm: Sequence[Sequence[float]], u_mm: float, rng: np.random.Generator) -> FloatArray:
    """Draw true places of nests that a certificate states, shape (m, 3): off by its uncertainty."""
    stated = np.array(nests_mm, dtype=np.float64).reshape(-1, 3)
    return stated + u_mm * rng.standard_normal(stated.shape)


def draw_effects(scenario: Scenario, plant: Plant, seed: int, rng: np.random.Generator) -> PlantedEffects:
    """Draw the everyday effects and plant the stated ones before them; raises ScenarioError.

    Stated changes come first, so that what they leave to chance is the same in a clean and in an everyday
    cell of one seed.
    """
    tool = scenario.tool
    everyday = scenario.everyday
    drawn = (
        ()
        if everyday is None
        else draw_everyday(everyday, plant.arm, plant.tool_mass, len(tool.nests_mm), rng)
    )
    site = _site(scenario, plant.compliance_rad_per_n_mm, seed)
    return PlantedEffects(site, (*scenario.effects, *drawn))


def nominal_site(scenario: Scenario) -> Site:
    """Return where an effect would be planted, to see whether it can be."""
    return _site(scenario, np.array(ARMS[scenario.robot].typical_compliance_rad_per_n_mm), seed=0)


def _site(scenario: Scenario, compliance_rad_per_n_mm: FloatArray, seed: int) -> Site:
    return Site(
        arm=ARMS[scenario.robot],
        compliance_rad_per_n_mm=compliance_rad_per_n_mm,
        tool_mass=_tool_mass(scenario),
        n_nests=len(scenario.tool.nests_mm),
        reference_c=scenario.air.temperature_c,
        entropy=(seed,),
    )


def _tool_mass(scenario: Scenario) -> CarriedMass | None:
    tool, joints = scenario.tool, ARMS[scenario.robot].n_joints
    return CarriedMass(joints, tool.mass_kg, tool.centre_of_gravity_mm) if tool.mass_kg else None
