"""The true cell: robot, artefact, table, tracker and air, on one clock and from one seed."""

import math
from collections.abc import Sequence

import numpy as np

from simulators.air import Air
from simulators.clock import CellClock
from simulators.faults import Fault, Faults
from simulators.physics.arm import CarriedMass
from simulators.physics.effects import Conditions, Effect, PlantedChange, plant_effect
from simulators.physics.equilibrium import Rest, find_rest
from simulators.physics.plant import Plant, draw_compliances, draw_motions
from simulators.physics.rigid import FloatArray, apply
from simulators.physics.robots import ARMS
from simulators.robot import JointMotion, Robot, SpeedLimits, check_range
from simulators.scenario import Scenario
from simulators.tracker import HOME_MM, Target, Tracker, place_tracker, returns_beam, seen_from


class Cell:
    """One cell. Instruments ask it; it knows no protocol."""

    def __init__(self, scenario: Scenario, seed: int, clock: CellClock) -> None:
        """Build the cell that `seed` gives; the plant does not depend on the order of readings.

        Raises ScenarioError or NoEquilibriumError for a cell that cannot be.
        """
        plant_rng, self.rng = (np.random.default_rng(part) for part in np.random.SeedSequence(seed).spawn(2))
        self.scenario = scenario
        self.seed = seed
        self.clock = clock
        self.faults = Faults()
        self.attachment = 1
        self.plant = _draw_plant(scenario, plant_rng)
        self.tool_nests_mm = _certified(scenario.tool.nests_mm, scenario.tool.nest_u_mm, plant_rng)
        self._fixed_nests_mm = _certified(scenario.table.fixed_nests_mm, scenario.table.nest_u_mm, plant_rng)
        self.air = Air(scenario.air, float(plant_rng.uniform(-math.pi, math.pi)))
        frame = place_tracker(scenario.tracker, plant_rng)
        self.tracker = Tracker(scenario.tracker, frame, self._targets, self.noise)
        scatter_mm = scenario.arm.scatter_mm if scenario.noise else 0.0
        self.robot = Robot(self.plant.arm, np.radians(scenario.arm.home_deg), scatter_mm, self.rng)
        self._effects: list[Effect] = [plant_effect(change, self.plant.arm) for change in scenario.effects]
        self._rest: tuple[tuple[float, ...], Rest] | None = None
        facing = np.array(scenario.tool.facing)
        self._facing = facing / np.linalg.norm(facing, axis=1, keepdims=True)
        for fault in scenario.faults:
            self.add_fault(fault)
        self._rest_now()  # springs so soft that the arm folds are refused here, not in front of a client

    @property
    def noise(self) -> np.random.Generator | None:
        """Source of reading noise, None in a noise-free cell."""
        return self.rng if self.scenario.noise else None

    def plant_change(self, change: PlantedChange) -> None:
        """Plant a physical change; raises ScenarioError."""
        self._effects.append(plant_effect(change, self.plant.arm))
        self._rest = None

    def add_fault(self, fault: Fault) -> None:
        """Script a failure; raises ScenarioError when it cannot happen here."""
        self.scenario.check_fault(fault)
        self.faults.add(fault)

    async def move_robot(
        self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits, tool_mm: FloatArray
    ) -> None:
        """Move along waypoints and return when the arm is at rest; raises TargetOutOfRangeError."""
        for waypoint in waypoints_rad:
            check_range(self.plant.arm, waypoint)
        motion = self.robot.start(waypoints_rad, limits, tool_mm, self.clock.now_s)
        self._lose_sight(motion)
        await self.clock.sleep(motion.duration_s)

    def true_positions(self, conditions: Conditions) -> FloatArray:
        """Tool nest centres without noise and scatter [mm, world], shape (n, nests, 3)."""
        return find_rest(self.plant, self._effects, conditions).nest_positions(self.tool_nests_mm)

    def conditions(
        self, joints_rad: FloatArray, direction: FloatArray, time_s: FloatArray, attachment: FloatArray
    ) -> Conditions:
        """Circumstances of n stops; the temperature follows from the times."""
        temperature = np.array([self.air.temperature_c(float(time)) for time in time_s])
        return Conditions(joints_rad, direction, time_s, temperature, attachment)

    def fixed_nests_mm(self) -> FloatArray:
        """Where the fixed nests are now [mm, world], shape (nests, 3)."""
        now = self.clock.now_s
        shifts = [self.faults.fixed_nest_shift_mm(i + 1, now) for i in range(len(self._fixed_nests_mm))]
        moved: FloatArray = self._fixed_nests_mm + np.array(shifts).reshape(-1, 3)
        return moved

    def _targets(self) -> list[Target]:
        """Every reflector in the cell, as the tracker may see it now."""
        now = self.clock.now_s
        if self.faults.blinded(now):
            return []
        tool = zip(self._tool_nests_now(), self._facing_now(), strict=True)
        frame = self.tracker.frame
        acceptance = math.radians(self.scenario.tool.acceptance_deg)
        targets = [
            Target(
                f"tool {number}",
                seen_from(frame, position),
                returns_beam(frame, position, facing, acceptance),
            )
            for number, (position, facing) in enumerate(tool, start=1)
            if not self.faults.smr_missing(number, now)
        ]
        fixed = enumerate(seen_from(frame, self.fixed_nests_mm()), start=1)
        home = Target("home", np.array(HOME_MM), True)
        return [*targets, *(Target(f"fixed {number}", position, True) for number, position in fixed), home]

    def _tool_nests_now(self) -> FloatArray:
        rest = self._rest_now().nest_positions(self.tool_nests_mm)[0]
        scatter = 0.0 if self.robot.moving(self.clock.now_s) else self.robot.scatter_mm
        position: FloatArray = rest + scatter
        return position

    def _facing_now(self) -> FloatArray:
        return apply(self._rest_now().bodies.last_frame[0, :3, :3], self._facing)

    def _rest_now(self) -> Rest:
        """Return the arm as it is now; found again only when something changed since."""
        now = self.clock.now_s
        moving = self.robot.moving(now)
        # Without effects nothing about a stop depends on time.
        key = (self.robot.stop_number, now if moving or self._effects else -1.0, self.attachment)
        if self._rest is None or self._rest[0] != key:
            self._rest = (key, self._find_rest(self.robot.motion.joints_at(now)[np.newaxis], now))
        return self._rest[1]

    def _find_rest(self, joints_rad: FloatArray, time_s: float) -> Rest:
        n = len(joints_rad)
        direction = np.broadcast_to(self.robot.direction, joints_rad.shape)
        attachment = np.full(n, float(self.attachment))
        stops = self.conditions(joints_rad, direction, np.full(n, time_s), attachment)
        return find_rest(self.plant, self._effects, stops)

    def _lose_sight(self, motion: JointMotion) -> None:
        """Break the lock on a tool nest that turns away from the tracker somewhere on the path."""
        name = self.tracker.target
        if name is None or not name.startswith("tool"):
            return
        number = int(name.removeprefix("tool ")) - 1
        rest = self._find_rest(motion.path_rad, motion.start_s)
        facing = apply(rest.bodies.last_frame[:, :3, :3], self._facing[number])
        positions = rest.nest_positions(self.tool_nests_mm[number : number + 1])[:, 0]
        acceptance = math.radians(self.scenario.tool.acceptance_deg)
        frame = self.tracker.frame
        if not all(returns_beam(frame, *pair, acceptance) for pair in zip(positions, facing, strict=True)):
            self.tracker.release()


def _certified(nests_mm: Sequence[Sequence[float]], u_mm: float, rng: np.random.Generator) -> FloatArray:
    """Draw true places of nests that a certificate states: off by its uncertainty."""
    stated = np.array(nests_mm, dtype=np.float64).reshape(-1, 3)
    return stated + u_mm * rng.standard_normal(stated.shape)


def _draw_plant(scenario: Scenario, rng: np.random.Generator) -> Plant:
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
    tool = scenario.tool
    tool_mass = CarriedMass(arm.n_joints, tool.mass_kg, tool.centre_of_gravity_mm) if tool.mass_kg else None
    return Plant(arm, motions, compliance, tool_mass)
