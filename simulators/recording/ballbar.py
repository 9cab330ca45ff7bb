"""A ballbar campaign without any wire, and a tracker campaign of the same robot to compare with.

The session comes first: tool triangle, then per placement cups, base triangle and legs. The tracker, which
has registered itself on the fixed nests before, reads the cups as they are clamped, and its own campaign
after the session.
"""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from simulators.ballbar_accuracy import rounded_mm, walked_zeros_mm
from simulators.cell import Cell
from simulators.clock import CellClock
from simulators.errors import ScenarioError
from simulators.physics.effects.ports import NestNumbers
from simulators.physics.identified import IdentifiedModel
from simulators.physics.rigid import FloatArray
from simulators.recording.ballbar_aiming import BoolArray, aim_balls, aim_legs
from simulators.recording.ballbar_plan import BallbarPlan, check_plan
from simulators.recording.ballbar_tour import PlannedLegs, Tour, plan_legs, plan_tour
from simulators.recording.campaign import Recording, record_in
from simulators.recording.plan import APPROACHES, Wishes
from simulators.recording.registered_tracker import RegisteredTracker
from simulators.robot import TargetOutOfRangeError, check_range
from simulators.scenario import Scenario

_CUP_READINGS = 10  # of each cup: 0.016 mm of one reading become 0.005
_STREAM = 102  # 100 and 101 are the tracker campaign's
_PLACEMENTS_OFF_MM = 50.0  # no robot is off by that much: the plan is of another cell


@dataclass(frozen=True, slots=True)
class BallbarWishes:
    """What a recorded ballbar campaign should be."""

    aimed: bool = False  # joints corrected as after a pre-calibration; else poses as planned
    aim_error_mm: float = 0.05  # standard deviation by which a pre-calibrated model misses a length
    approach: str = "mixed"
    tracker: Wishes = field(default_factory=lambda: Wishes(configurations=50, validation=3000, attachments=1))

    def __post_init__(self) -> None:
        if self.aim_error_mm < 0.0:
            raise ScenarioError(f'"aim_error_mm" must be 0 or more, not {self.aim_error_mm}')
        if self.approach not in APPROACHES:
            raise ScenarioError(f'"approach" must be {" or ".join(APPROACHES)}, not "{self.approach}"')


@dataclass(frozen=True, slots=True)
class Legs:
    """n legs that were read, or that were out of range."""

    placement: NestNumbers  # (n,)
    config: NestNumbers  # (n,)
    joints_deg: FloatArray  # (n, J) commanded
    direction: FloatArray  # (n, J)
    time_s: FloatArray  # (n,)
    temperature_c: FloatArray  # (n,) as sensed
    attachment: FloatArray  # (n,)
    init: NestNumbers  # (n,) number of the last initialisation
    base_point: NestNumbers  # (n,)
    tool_point: NestNumbers  # (n,)
    length_mm: FloatArray  # (n,)
    true_mm: FloatArray  # (n,) of the pair that is written down, without noise, scatter and zero

    def __len__(self) -> int:
        return len(self.length_mm)

    def part(self, rows: NestNumbers) -> "Legs":
        """Return some of the legs."""
        return Legs(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


@dataclass(frozen=True, slots=True)
class Sides:
    """m sides of triangles; placement 0 is the tool's."""

    placement: NestNumbers  # (m,)
    point_a: NestNumbers  # (m,)
    point_b: NestNumbers  # (m,)
    length_mm: FloatArray  # (m,)


@dataclass(frozen=True, slots=True)
class Cups:
    """k cups, clamped where the robot held the ball."""

    placement: NestNumbers  # (k,)
    base_point: NestNumbers  # (k,)
    joints_deg: FloatArray  # (k, J) at which the robot held it
    true_mm: FloatArray  # (k, 3) world, as clamped
    read_mm: FloatArray  # (k, 3) by the tracker
    u_mm: FloatArray  # (k,) of the tracker's readings, per axis


@dataclass(frozen=True, slots=True)
class BallbarRecording:
    """One ballbar campaign, the tracker campaign beside it, and the truth."""

    cell: Cell
    legs: Legs
    out_of_range: Legs  # with the lengths that they would have had
    not_reached: tuple[int, ...]  # configs that the arm could not correct, aimed campaigns only
    sides: Sides
    cups: Cups
    tracker: Recording
    true_validation_mm: FloatArray  # (n, nests, 3) at the validation stops, without noise and scatter
    u_mm: float  # standard uncertainty of a length


def record_ballbar(
    scenario: Scenario,
    seed: int,
    plan: BallbarPlan,
    wishes: BallbarWishes,
    model: IdentifiedModel | None = None,
) -> BallbarRecording:
    """Record a ballbar campaign of the cell that scenario, seed and perhaps a model give.

    The tracker campaign beside it is that of `campaign.record` at later times, whatever the plan: plans can
    be compared on one robot.

    Raises
    ------
    SimulatorError
        The cell cannot be, the plan does not go with it, or its tracker sees too few configurations.
    """
    cell = Cell(scenario, seed, CellClock(0), model)
    check_plan(plan, cell)
    streams = np.random.SeedSequence(seed, spawn_key=(_STREAM,)).spawn(3)
    person_rng, arm_rng, instrument_rng = (np.random.default_rng(stream) for stream in streams)
    tour = plan_tour(plan, wishes.approach, person_rng)
    recording, tracker = record_in(cell, wishes.tracker, float(tour.end_s[-1]))
    tour = _set_up_anew(cell, plan, tour, wishes, arm_rng) if wishes.aimed else tour
    cups = _clamp_cups(cell, tour, tracker, arm_rng)
    _check_cups(plan, cups)
    legs = plan_legs(plan, tour, scenario.ballbar.nominal_mm)
    tour, reached = _aimed(cell, tour, legs, cups, wishes, arm_rng) if wishes.aimed else (tour, None)
    _check_reach(cell, tour)
    scatter = _drawn(cell, scenario.arm.scatter_mm, (len(tour), 3), arm_rng)
    instrument = _Instrument(cell, instrument_rng)
    sides = instrument.read_sides(cups)
    read = instrument.read_legs(tour, legs, cups, scatter)
    in_range = np.abs(read.length_mm - scenario.ballbar.nominal_mm) <= scenario.ballbar.range_mm
    kept = np.ones(len(read), dtype=bool) if reached is None else reached
    return BallbarRecording(
        cell=cell,
        legs=read.part(np.flatnonzero(in_range & kept)),
        out_of_range=read.part(np.flatnonzero(~in_range & kept)),
        not_reached=tuple(sorted({int(config) for config in read.config[~kept]})),
        sides=sides,
        cups=cups,
        tracker=recording,
        true_validation_mm=_true_validation_mm(cell, recording),
        u_mm=scenario.ballbar.stated_u_mm,
    )


def _drawn(cell: Cell, size: float, shape: tuple[int, ...], rng: np.random.Generator) -> FloatArray:
    return (size if cell.scenario.noise else 0.0) * rng.standard_normal(shape)


def _clamp_cups(cell: Cell, tour: Tour, tracker: RegisteredTracker, rng: np.random.Generator) -> Cups:
    """Clamp every cup where the true robot holds the ball in tool nest 1, and have the tracker read it."""
    stops = np.flatnonzero(tour.is_setup)
    times = tour.end_s[stops]
    held = cell.true_positions(tour.conditions(cell, stops, times))[:, 0]
    size_mm = float(np.hypot(cell.scenario.arm.scatter_mm, cell.scenario.ballbar.clamp_mm))
    true = held + _drawn(cell, size_mm, held.shape, rng)
    readings = tracker.read(np.repeat(true, _CUP_READINGS, axis=0), np.repeat(times, _CUP_READINGS))
    return Cups(
        placement=tour.placement[stops],
        base_point=tour.number[stops],
        joints_deg=tour.joints_deg[stops],
        true_mm=true,
        read_mm=readings.position_mm.reshape(-1, _CUP_READINGS, 3).mean(axis=1),
        u_mm=readings.u_mm[::_CUP_READINGS] / np.sqrt(_CUP_READINGS),
    )


def _check_cups(plan: BallbarPlan, cups: Cups) -> None:
    """Refuse a plan whose set-ups do not lead to the cups that it states."""
    for placement in plan.placements:
        for point, stated in enumerate(placement.cups_mm, start=1):
            mine = (cups.placement == placement.number) & (cups.base_point == point)
            off_mm = float(np.linalg.norm(cups.true_mm[mine] - np.array(stated), axis=1).max(initial=0.0))
            if off_mm > _PLACEMENTS_OFF_MM:
                raise ScenarioError(
                    f"placement {placement.number}: at the joints of set-up {point} the ball is"
                    f" {off_mm:.0f} mm from the cup as planned; joints are in deg, cups in the world"
                )


def _aimed(
    cell: Cell, tour: Tour, legs: PlannedLegs, cups: Cups, wishes: BallbarWishes, rng: np.random.Generator
) -> tuple[Tour, BoolArray]:
    wanted = legs.aimed_mm + wishes.aim_error_mm * rng.standard_normal(len(legs.aimed_mm))
    joints, reached = aim_legs(cell, tour, legs, _cups_of(legs, tour, cups), wanted)
    return tour.at_joints(joints, wishes.approach), reached


def _set_up_anew(
    cell: Cell, plan: BallbarPlan, tour: Tour, wishes: BallbarWishes, rng: np.random.Generator
) -> Tour:
    """Aim the set-ups of later placements: the legs of the first are what the model learnt from."""
    stated = {
        (placement.number, point): cup
        for placement in plan.placements[1:]
        for point, cup in enumerate(placement.cups_mm, start=1)
    }
    stops = np.array(
        [
            stop
            for stop in np.flatnonzero(tour.is_setup)
            if (int(tour.placement[stop]), int(tour.number[stop])) in stated
        ],
        dtype=int,
    )
    if not len(stops):
        return tour
    wanted = np.array([stated[int(tour.placement[stop]), int(tour.number[stop])] for stop in stops])
    wanted = wanted + wishes.aim_error_mm * rng.standard_normal(wanted.shape)
    return tour.at_joints(aim_balls(cell, tour, stops, wanted), wishes.approach)


def _cups_of(legs: PlannedLegs, tour: Tour, cups: Cups) -> FloatArray:
    """Cup of each leg as clamped, shape (n, 3)."""
    placement = tour.placement[legs.stop]
    mine = (placement[:, np.newaxis] == cups.placement) & (legs.base_point[:, np.newaxis] == cups.base_point)
    found: FloatArray = cups.true_mm[mine.argmax(axis=1)]
    return found


def _check_reach(cell: Cell, tour: Tour) -> None:
    for stop in range(len(tour)):
        try:
            check_range(cell.plant.arm, np.radians(tour.joints_deg[stop]))
        except TargetOutOfRangeError as error:
            what = "set-up" if tour.is_setup[stop] else "config"
            raise ScenarioError(
                f"placement {tour.placement[stop]}, {what} {tour.number[stop]}: {error}"
            ) from error


class _Instrument:
    """The ballbar, initialised before every group of readings."""

    def __init__(self, cell: Cell, rng: np.random.Generator) -> None:
        self._cell = cell
        self._setup = cell.scenario.ballbar
        self._rng = rng

    def read_sides(self, cups: Cups) -> Sides:
        """Measure the tool's triangle, then that of each placement."""
        corners = [(0, self._cell.true_nests_mm(self._cell.conditions_now())[0])]
        for number in dict.fromkeys(cups.placement.tolist()):
            mine = cups.placement == number
            corners.append((number, cups.true_mm[mine][np.argsort(cups.base_point[mine])]))
        rows = []
        for number, points in corners:
            pairs = list(combinations(range(len(points)), 2))
            true = np.array([np.linalg.norm(points[b] - points[a]) for a, b in pairs])
            nominal = self._setup.nominal_mm if number else self._setup.tool_nominal_mm
            for (a, b), length in zip(pairs, self._group(true), strict=True):
                if abs(length - nominal) <= self._setup.range_mm:
                    rows.append((number, a + 1, b + 1, length))
        table = np.array(rows).reshape(-1, 4)
        placement, first, second = (table[:, k].astype(int) for k in range(3))
        return Sides(placement, first, second, table[:, 3])

    def read_legs(self, tour: Tour, legs: PlannedLegs, cups: Cups, scatter_mm: FloatArray) -> Legs:
        """Read all legs, in and out of range."""
        cell, n = self._cell, len(legs.stop)
        conditions = tour.conditions(cell, legs.stop, legs.time_s)
        positions = cell.true_positions(conditions)
        cup = _cups_of(legs, tour, cups)
        connected = cell.nests_read(legs.tool_point, legs.time_s)
        stood = positions[np.arange(n), connected - 1] + scatter_mm[legs.stop]
        stops, group = np.unique(legs.stop, return_inverse=True)
        true = np.linalg.norm(stood - cup, axis=1)
        length = np.concatenate([self._group(true[group == k]) for k in range(len(stops))])
        sensor = cell.scenario.air.sensor_noise_k if cell.scenario.noise else 0.0
        return Legs(
            placement=tour.placement[legs.stop],
            config=tour.number[legs.stop],
            joints_deg=tour.joints_deg[legs.stop],
            direction=tour.direction[legs.stop],
            time_s=legs.time_s,
            temperature_c=conditions.temperature_c + sensor * self._rng.standard_normal(n),
            attachment=conditions.attachment,
            init=_initialisations(tour)[legs.stop],
            base_point=legs.base_point,
            tool_point=legs.tool_point,
            length_mm=length,
            true_mm=np.linalg.norm(positions[np.arange(n), legs.tool_point - 1] - cup, axis=1),
        )

    def _group(self, true_mm: FloatArray) -> FloatArray:
        """Read lengths after one initialisation, shape (n,)."""
        if not self._cell.scenario.noise:
            return true_mm
        noise = self._setup.noise_mm * self._rng.standard_normal(len(true_mm))
        return rounded_mm(
            self._setup, true_mm + noise + walked_zeros_mm(self._setup, len(true_mm), self._rng)
        )


def _initialisations(tour: Tour) -> NestNumbers:
    """Return the number of the last initialisation at every stop.

    The first is the tool's, then there is one for every base triangle and every pose.
    """
    first_pose = ~tour.is_setup & np.concatenate([[False], tour.is_setup[:-1]])
    numbers: NestNumbers = 1 + np.cumsum(~tour.is_setup) + np.cumsum(first_pose)
    return numbers


def _true_validation_mm(cell: Cell, recording: Recording) -> FloatArray:
    stops = recording.validation.stops
    return cell.true_positions(
        cell.conditions(np.radians(stops.joints_deg), stops.direction, stops.time_s, stops.attachment)
    )
