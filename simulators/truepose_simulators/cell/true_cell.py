"""The true cell: robot, artefact, table, tracker and air, on one clock and from one seed."""

import math
from collections.abc import Sequence

import numpy as np

from truepose_simulators.cell.building import draw_effects, draw_nests, draw_plant, with_model
from truepose_simulators.cell.environment import Air, CellClock
from truepose_simulators.cell.planted import PlantedEffects
from truepose_simulators.cell.robot import JointMotion, Robot, SpeedLimits, check_range
from truepose_simulators.cell.simulated_operator import equip
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import ArmStopped, TrackerBlinded, WrongCup
from truepose_simulators.faults.scripted import Faults
from truepose_simulators.faults.times import Fault
from truepose_simulators.instruments.gauges.loop import LoopGauge, LoopSetup, Tool, loop_gauges
from truepose_simulators.instruments.tracker import (
    HOME_MM,
    Target,
    Tracker,
    in_tracker_frame,
    place_tracker,
    returns_beam,
)
from truepose_simulators.physics.effects import Conditions, PlantedChange
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.identified import IdentifiedModel, realise
from truepose_simulators.physics.rigid import FloatArray, apply, small_motion
from truepose_simulators.physics.true_robot import Rest, find_rest
from truepose_simulators.scenarios.scenario import Scenario

# Enough configurations all over the ranges that an arm which folds under its weight does so in one of them.
_TRIED_STOPS = 32
_LOOK_S = 0.1  # between two looks at whether something stops the arm


class Cell:
    """One cell. Instruments ask it; it knows no protocol."""

    def __init__(
        self, scenario: Scenario, seed: int, clock: CellClock, model: IdentifiedModel | None = None
    ) -> None:
        """Build the cell that `seed` gives; the plant does not depend on the order of readings.

        With a model its robot stands in the place of the scenario's; cell time 0 is the origin of its times.

        Raises ScenarioError, ModelError or NoEquilibriumError for a cell that cannot be.
        """
        identified = None if model is None else realise(model)
        if model is not None and identified is not None:
            scenario = with_model(scenario, model, identified)
        # One more part leaves the others as they are: older cells keep their numbers.
        *parts, of_equipment, of_curves, of_loop = np.random.SeedSequence(seed).spawn(7)
        plant_rng, self.rng, everyday_rng, self._spoil_rng = (np.random.default_rng(part) for part in parts)
        self.model = model
        self.scenario = scenario
        self.seed = seed
        self.clock = clock
        self.faults = Faults(lambda: clock.now_s)
        self.attachment = 1
        self.plant = draw_plant(scenario, plant_rng) if identified is None else identified.plant
        self.tool_nests_mm = draw_nests(scenario.tool.nests_mm, scenario.tool.nest_u_mm, plant_rng)
        self._fixed_nests_mm = draw_nests(scenario.table.fixed_nests_mm, scenario.table.nest_u_mm, plant_rng)
        effects = () if identified is None else identified.effects
        curves_rng = np.random.default_rng(of_curves)
        self.planted = draw_effects(scenario, self.plant, seed, everyday_rng, curves_rng, effects)
        phase_rad = float(plant_rng.uniform(-math.pi, math.pi))
        self.air = Air(scenario.air, phase_rad, self._warming_k)
        self._first_frame = place_tracker(scenario.tracker, plant_rng)
        self.tracker = Tracker(scenario.tracker, self._frame_now, self._targets, self.noise, self._spoil)
        scatter_mm = scenario.arm.scatter_mm if scenario.noise else 0.0
        self.robot = Robot(self.plant.arm, np.radians(scenario.arm.home_deg), scatter_mm, self.rng)
        self._stop: tuple[tuple[float, ...], Rest, FloatArray] | None = None
        self._standing: tuple[tuple[float, ...], FloatArray] | None = None
        self.hands = equip(scenario, lambda: self.planted, self.air, self, of_equipment)
        self.ballbar, self.fixture = self.hands.ballbar, self.hands.fixture
        self.loop = () if scenario.loop is None else self._loop(scenario.loop, of_loop)
        facing = np.array(scenario.tool.facing)
        self.facing = facing / np.linalg.norm(facing, axis=1, keepdims=True)  # (nests, 3) flange frame
        for fault in scenario.faults:
            self.add_fault(fault)
        # Springs so soft that the arm folds are refused here, not in front of a client.
        self._check_stands(self.planted, max((change.from_s for change in scenario.effects), default=0.0))

    @property
    def noise(self) -> np.random.Generator | None:
        """Source of reading noise, None in a noise-free cell."""
        return self.rng if self.scenario.noise else None

    def plant_change(self, change: PlantedChange) -> None:
        """Plant a change; raises ScenarioError or NoEquilibriumError, and then nothing has changed."""
        planted = self.planted.with_change(change)
        self._check_stands(planted, change.from_s)
        self.planted = planted
        self._stop = None

    def mount_tool_anew(self) -> None:
        """Take the tool off and put it on again."""
        self.attachment += 1

    def add_fault(self, fault: Fault) -> int:
        """Script a failure and return its number; raises ScenarioError when it cannot happen here."""
        self.scenario.check_fault(fault)
        return self.faults.add(fault)

    async def move_robot(
        self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits, tool_mm: FloatArray
    ) -> None:
        """Move along waypoints until at rest; raises TargetOutOfRangeError and ArmStoppedError."""
        await self.glide(self.set_off(waypoints_rad, limits, tool_mm).duration_s)

    def set_off(
        self, waypoints_rad: Sequence[FloatArray], limits: SpeedLimits, tool_mm: FloatArray
    ) -> JointMotion:
        """Begin to move along waypoints; raises TargetOutOfRangeError, and then nothing has moved."""
        for waypoint in waypoints_rad:
            check_range(self.plant.arm, waypoint)
        motion = self.robot.start(waypoints_rad, limits, tool_mm, self.clock.now_s)
        self._lose_sight(motion)
        self.hands.follow(motion)
        return motion

    async def glide(self, duration_s: float) -> None:
        """Let so much time go by in a motion; raises ArmStoppedError where something stops it."""
        end_s = self.clock.now_s + duration_s
        while not self.faults.holds(ArmStopped, self.clock.now_s):
            left_s = self.faults.begins_s(ArmStopped, end_s) - self.clock.now_s
            if left_s <= 0.0:
                return
            # Where time is real a stop may be given meanwhile.
            await self.clock.sleep(min(left_s, _LOOK_S) if self.clock.waits else left_s)
        self.halt_robot()
        raise ArmStoppedError("the arm was stopped and does not move until the stop is released")

    def measured_here(self) -> None:
        """Note that something on the tool is read where the arm stands: that is what faults count."""
        self.faults.measured_at(tuple(self.robot.target_rad.tolist()))

    def halt_robot(self) -> None:
        """Stop the arm where it is now; without a motion under way that is nothing."""
        self.robot.halt(self.clock.now_s)

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""
        return self.clock.now_s

    @property
    def joints_rad(self) -> FloatArray:
        """Joint angles now as the controller has them, shape (J,)."""
        return self.robot.motion.joints_at(self.clock.now_s)

    @property
    def robot_serial(self) -> str:
        """Serial number that the robot's controller tells now."""
        return self.faults.serial("robot", f"SIM-{self.seed}", self.clock.now_s)

    @property
    def robot_moves(self) -> bool:
        """Whether the arm is under way."""
        return self.robot.moving(self.clock.now_s)

    def nests_at_mm(self, time_s: float) -> FloatArray:
        """Where the tool nests are at a cell time with the arm's scatter, shape (nests, 3) [world]."""
        if self.robot.moving(time_s):
            return self._nests_mm(self.robot.motion.joints_at(time_s), time_s)
        # Nothing but a planted change does anything to a standing arm that shows within a second.
        changes = sum(change.from_s <= time_s for change in self.planted.changes)
        second = math.floor(time_s) if self.planted else 0
        slipped = self.faults.tool_shift_mm(time_s)
        planted = len(self.planted.changes)
        key = (self.robot.stop_number, second, changes, planted, self.attachment, *slipped)
        if self._standing is None or self._standing[0] != key:
            nests = self._nests_mm(self.robot.target_rad, time_s)
            self._standing = (key, nests + self.robot.scatter_mm)
        return self._standing[1]

    def nests_along_mm(self, motion: JointMotion) -> FloatArray:
        """Where the tool nests come along a motion, shape (m, nests, 3) [world]."""
        return self.true_positions(self._conditions(motion.path_rad, motion.start_s))

    def nest_taken(self, nest: int) -> int:
        """Return the nest that is truly taken for `nest` now; another one where labels are swapped."""
        return int(self.nests_read(np.array([nest]), np.array([self.clock.now_s]))[0])

    def cup_taken(self, cup: int) -> int:
        """Return the cup of the base that the person truly takes for `cup` now."""
        self.measured_here()
        slip = self.faults.next_connection()
        return slip.cup if isinstance(slip, WrongCup) else cup

    def wild_mm(self) -> float:
        """By how much a length that is connected now is read wrong."""
        return float(self.wild_lengths_mm(np.array([self.clock.now_s]))[0])

    def true_positions(self, conditions: Conditions) -> FloatArray:
        """Tool nest centres without noise and scatter [mm, world], shape (n, nests, 3)."""
        return self.rest(conditions).nest_positions(self.true_nests_mm(conditions))

    def rest(self, conditions: Conditions) -> Rest:
        """Let the arm come to rest."""
        return find_rest(self.plant, self.planted.arm, conditions, self.planted.mass_changes(conditions))

    def true_nests_mm(self, conditions: Conditions) -> FloatArray:
        """Tool nests where they truly are, flange frame, shape (1 or n, nests, 3)."""
        places: FloatArray = self.tool_nests_mm + self.planted.nest_offsets_mm(conditions)
        if not self.faults.moves_frames:
            return places
        slipped = np.array([self.faults.tool_shift_mm(float(at_s)) for at_s in conditions.time_s])
        shifted: FloatArray = places + slipped[:, np.newaxis]
        return shifted

    def conditions(
        self, joints_rad: FloatArray, direction: FloatArray, time_s: FloatArray, attachment: FloatArray
    ) -> Conditions:
        """Circumstances of n stops; the temperature follows from the times."""
        return Conditions(joints_rad, direction, time_s, self.air.temperature_c(time_s), attachment)

    def conditions_now(self) -> Conditions:
        """Circumstances of the arm as it is now."""
        return self._conditions(self.joints_rad[np.newaxis], self.clock.now_s)

    def fixed_nests_mm(self) -> FloatArray:
        """Where the fixed nests are now [mm, world], shape (nests, 3)."""
        now = self.clock.now_s
        shifts = [self.faults.fixed_nest_shift_mm(i + 1, now) for i in range(len(self._fixed_nests_mm))]
        moved: FloatArray = self._fixed_nests_mm + np.array(shifts).reshape(-1, 3)
        return moved

    def tracker_frames(self, time_s: FloatArray) -> FloatArray:
        """Where the tracker stands in the world at times, shape (n,) -> (n, 4, 4)."""
        moved = self.planted.frame_motion(time_s)
        if self.faults.moves_frames:
            moved = moved + np.array([self.faults.tracker_motion(float(at_s)) for at_s in time_s])
        frames: FloatArray = small_motion(moved) @ self._first_frame
        return frames

    def spoiled(self, reading_mm: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return what planted effects make of readings in the tracker frame, shape (n, 3)."""
        scale = 1.0 + self.planted.relative_scale(time_s)[:, np.newaxis]
        spoiled: FloatArray = reading_mm * scale + self.planted.displacement_mm(time_s, self._spoil_rng)
        return spoiled

    def wild_lengths_mm(self, time_s: FloatArray) -> FloatArray:
        """Return what planted effects add to single lengths, shape (n,)."""
        return self.planted.wild_mm(time_s, self._spoil_rng)

    def nests_read(self, nest: NestNumbers, time_s: FloatArray) -> NestNumbers:
        """Nests (1-based) that are truly read under the labels `nest`, shape (n,)."""
        return self.planted.nests_read(nest, time_s, self._spoil_rng)

    def _warming_k(self, time_s: FloatArray) -> FloatArray:
        warmer = self.planted.warming_k(time_s)
        if self.faults.moves_frames:
            warmer = warmer + np.array([self.faults.warming_k(float(at_s)) for at_s in time_s])
        return warmer

    def _loop(self, setup: LoopSetup, seed: np.random.SeedSequence) -> tuple[LoopGauge, ...]:
        def tool() -> Tool:
            rotation = self._stop_now()[0].bodies.last_frame[0, :3, :3]
            return Tool(rotation, self._tool_nests_now()[setup.nest - 1])

        return loop_gauges(setup, tool, np.random.default_rng(seed), noise=self.scenario.noise)

    def _nests_mm(self, joints_rad: FloatArray, time_s: float) -> FloatArray:
        nests: FloatArray = self.true_positions(self._conditions(joints_rad[np.newaxis], time_s))[0]
        return nests

    def _frame_now(self) -> FloatArray:
        if not self.planted and not self.faults.moves_frames:
            return self._first_frame
        now: FloatArray = self.tracker_frames(np.array([self.clock.now_s]))[0]
        return now

    def _spoil(self, target: str, reading_mm: FloatArray) -> FloatArray:
        """Return what the tracker makes of one reading now."""
        if not self.planted:
            return reading_mm
        now = np.array([self.clock.now_s])
        if target.startswith("tool"):
            nest = int(target.removeprefix("tool "))
            read = int(self.nests_read(np.array([nest]), now)[0])
            places = in_tracker_frame(self.tracker.frame, self._tool_nests_now())
            reading_mm = reading_mm + places[read - 1] - places[nest - 1]
        spoiled: FloatArray = self.spoiled(reading_mm[np.newaxis], now)[0]
        return spoiled

    def _targets(self) -> list[Target]:
        """Every reflector in the cell, as the tracker may see it now."""
        now = self.clock.now_s
        if self.faults.holds(TrackerBlinded, now):
            return []
        frame = self.tracker.frame
        acceptance = math.radians(self.scenario.tool.acceptance_deg)
        positions = self._tool_nests_now()
        visible = returns_beam(frame, positions, self._facing_now(), acceptance)
        tool = enumerate(zip(in_tracker_frame(frame, positions), visible, strict=True), start=1)
        targets = [
            Target(f"tool {number}", position, bool(seen))
            for number, (position, seen) in tool
            if not self.faults.smr_missing(number, now)
        ]
        fixed = enumerate(in_tracker_frame(frame, self.fixed_nests_mm()), start=1)
        home = Target("home", np.array(HOME_MM), True)
        return [*targets, *(Target(f"fixed {number}", position, True) for number, position in fixed), home]

    def _tool_nests_now(self) -> FloatArray:
        scatter = 0.0 if self.robot.moving(self.clock.now_s) else self.robot.scatter_mm
        position: FloatArray = self._stop_now()[1] + scatter
        return position

    def _facing_now(self) -> FloatArray:
        return apply(self._stop_now()[0].bodies.last_frame[0, :3, :3], self.facing)

    def _stop_now(self) -> tuple[Rest, FloatArray]:
        """Return the arm as it is now and its nests (nests, 3); found again only when something changed."""
        now = self.clock.now_s
        moving = self.robot.moving(now)
        # Without effects nothing about a stop depends on time.
        changes = moving or self.planted or self.faults.moves_frames
        key = (self.robot.stop_number, now if changes else -1.0, self.attachment)
        if self._stop is None or self._stop[0] != key:
            conditions = self.conditions_now()
            rest = self.rest(conditions)
            self._stop = (key, rest, rest.nest_positions(self.true_nests_mm(conditions))[0])
        return self._stop[1:]

    def _conditions(self, joints_rad: FloatArray, time_s: float) -> Conditions:
        n = len(joints_rad)
        direction = np.broadcast_to(self.robot.direction, joints_rad.shape)
        attachment = np.full(n, float(self.attachment))
        return self.conditions(joints_rad, direction, np.full(n, time_s), attachment)

    def _check_stands(self, planted: PlantedEffects, time_s: float) -> None:
        """Raise NoEquilibriumError when the arm would fold under its weight with these effects."""
        lower, upper = self.plant.arm.limits_rad.T
        # Draws of its own: this check must not shift what the cell draws for its readings.
        tries = np.random.default_rng(0).uniform(lower, upper, (_TRIED_STOPS, len(lower)))
        conditions = self._conditions(tries, time_s)
        find_rest(self.plant, planted.arm, conditions, planted.mass_changes(conditions))

    def _lose_sight(self, motion: JointMotion) -> None:
        """Break the lock on a tool nest that turns away from the tracker somewhere on the path."""
        name = self.tracker.target
        if name is None or not name.startswith("tool"):
            return
        nest = int(name.removeprefix("tool ")) - 1
        conditions = self._conditions(motion.path_rad, motion.start_s)
        rest = self.rest(conditions)
        facing = apply(rest.bodies.last_frame[:, :3, :3], self.facing[nest])
        positions = rest.nest_positions(self.true_nests_mm(conditions))[:, nest]
        acceptance = math.radians(self.scenario.tool.acceptance_deg)
        if not returns_beam(self.tracker.frame, positions, facing, acceptance).all():
            self.tracker.release()
