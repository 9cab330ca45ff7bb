"""From a scenario, a seed and perhaps an identified model to the true parts of a cell."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from truepose_simulators.cell.drawn_effects import draw_curves, draw_everyday
from truepose_simulators.cell.planted import PlantedEffects
from truepose_simulators.physics.arm import Arm, CarriedMass
from truepose_simulators.physics.effects import Effect, PlantedChange, Site
from truepose_simulators.physics.identified import IdentifiedModel, IdentifiedRobot
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.physics.table_arm import vector
from truepose_simulators.physics.true_robot import Plant, draw_compliances, draw_motions
from truepose_simulators.scenarios.scenario import ArmSetup, Scenario, ToolSetup

_SEEN_FROM_EVERYWHERE_DEG = 180.0


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


def with_model(scenario: Scenario, model: IdentifiedModel, robot: IdentifiedRobot) -> Scenario:
    """Return the scenario with the model's tool and tracker in place of its own.

    Table, air, noise, faults and planted changes stay; what the robot itself was drawn from goes.
    """
    place = scenario.tracker.position_mm if model.instrument_mm is None else model.instrument_mm
    return replace(
        scenario,
        base=None,
        links=(),
        everyday=None,
        curves=None,
        arm=replace(scenario.arm, home_deg=_home_deg(scenario.arm, robot.plant.arm)),
        tool=_tool(scenario.tool, robot.nests_mm),
        tracker=replace(scenario.tracker, position_mm=place),
    )


def _home_deg(setup: ArmSetup, arm: Arm) -> tuple[float, ...]:
    """Return the scenario's home where the arm has it, else all joints as near to zero as they go."""
    stated = setup.home_deg if len(setup.home_deg) == arm.n_joints else (0.0,) * arm.n_joints
    lower, upper = np.degrees(arm.limits_rad.T)
    return tuple(float(angle) for angle in np.clip(stated, lower, upper))


def _tool(setup: ToolSetup, nests_mm: FloatArray) -> ToolSetup:
    """Return the model's nests; a model does not say where they face, the scenario's own three do."""
    nests = tuple(vector(nest) for nest in nests_mm)
    facing, acceptance = setup.facing, setup.acceptance_deg
    if len(nests) != len(setup.nests_mm):
        facing, acceptance = ((0.0, 0.0, 1.0),) * len(nests), _SEEN_FROM_EVERYWHERE_DEG
    # The masses of the model contain its tool.
    return replace(
        setup, nests_mm=nests, facing=facing, acceptance_deg=acceptance, nest_u_mm=0.0, mass_kg=0.0
    )


def draw_nests(nests_mm: Sequence[Sequence[float]], u_mm: float, rng: np.random.Generator) -> FloatArray:
    """Draw true places of nests that a certificate states, shape (m, 3): off by its uncertainty."""
    stated = np.array(nests_mm, dtype=np.float64).reshape(-1, 3)
    return stated + u_mm * rng.standard_normal(stated.shape)


def draw_effects(
    scenario: Scenario,
    plant: Plant,
    seed: int,
    everyday_rng: np.random.Generator,
    curves_rng: np.random.Generator,
    identified: Sequence[Effect] = (),
) -> PlantedEffects:
    """Draw everyday effects and curves and plant the stated ones before them; raises ScenarioError.

    Stated changes come first, so that what they leave to chance is the same in a clean and in an everyday
    cell of one seed. Those that a model identified act besides.
    """
    arm, tool_mass = plant.arm, plant.tool_mass
    drawn: tuple[PlantedChange, ...] = ()
    if scenario.everyday is not None:
        drawn = draw_everyday(scenario.everyday, arm, tool_mass, len(scenario.tool.nests_mm), everyday_rng)
    if scenario.curves is not None:
        drawn = (*drawn, *draw_curves(scenario.curves, arm, curves_rng))
    site = _site(scenario, arm, tool_mass, plant.compliance_rad_per_n_mm, seed)
    return PlantedEffects(site, (*scenario.effects, *drawn), identified)


def nominal_site(scenario: Scenario) -> Site:
    """Return where an effect would be planted, to see whether it can be."""
    arm = ARMS[scenario.robot]
    typical = np.array(arm.typical_compliance_rad_per_n_mm)
    return _site(scenario, arm, _tool_mass(scenario), typical, seed=0)


def _site(
    scenario: Scenario,
    arm: Arm,
    tool_mass: CarriedMass | None,
    compliance_rad_per_n_mm: FloatArray,
    seed: int,
) -> Site:
    return Site(
        arm=arm,
        compliance_rad_per_n_mm=compliance_rad_per_n_mm,
        tool_mass=tool_mass,
        n_nests=len(scenario.tool.nests_mm),
        reference_c=scenario.air.temperature_c,
        entropy=(seed,),
    )


def _tool_mass(scenario: Scenario) -> CarriedMass | None:
    tool, joints = scenario.tool, ARMS[scenario.robot].n_joints
    return CarriedMass(joints, tool.mass_kg, tool.centre_of_gravity_mm) if tool.mass_kg else None
