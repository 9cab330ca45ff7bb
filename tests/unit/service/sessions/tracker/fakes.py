"""A cell made of plain objects: clock, robot, tracker and journal that do as they are told."""

import asyncio
import math
from collections.abc import Awaitable, Callable
from functools import lru_cache
from typing import Any

import numpy as np

from tests.unit.service.sessions.stand_ins import Controller, Device, FiniteDisk, nothing_in_the_way
from truepose.domain.arrays import FloatArray
from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.robot import FixedNest, FramePlacement, JointRange, JointRow, Nest, Robot
from truepose.domain.session import (
    FixedNestTaken,
    IdentityTaken,
    PlannedStop,
    PointTaken,
    Progress,
    Registration,
    SessionPlan,
    SessionState,
    StopSkipped,
    config_of,
)
from truepose.kinematics.frames import rotation_xyz
from truepose.messages.catalogue import english
from truepose.sessions.engine.nominal_arm import nest_in_world
from truepose.sessions.tracker.cell import SessionCell
from truepose_drivers.api import (
    Environment,
    JointReading,
    TrackerReading,
    Vector,
)
from truepose_drivers.errors import ConnectionLostError, DriverError, ReflectorNotFoundError

QUARTER = math.pi / 2
IRB120 = Robot(
    name="IRB 120",
    joints=(
        JointRow(0.0, 0.0, 0.0, 290.0),
        JointRow(-QUARTER, 0.0, -QUARTER, 0.0),
        JointRow(0.0, 270.0, 0.0, 0.0),
        JointRow(-QUARTER, 70.0, 0.0, 302.0),
        JointRow(QUARTER, 0.0, 0.0, 0.0),
        JointRow(-QUARTER, 0.0, math.pi, 72.0),
    ),
    calibration_ranges=tuple(
        JointRange(math.radians(low), math.radians(high))
        for low, high in ((-90, 90), (0, 90), (-80, 50), (-150, 150), (-90, 90), (-180, 180))
    ),
)
NESTS = (Nest((0.0, 0.0, 125.0)), Nest((75.0, 93.675, 215.0)), Nest((150.0, 0.0, 125.0)))
FIXED_NESTS = tuple(
    FixedNest(centre, 0.002) for centre in ((600.0, 500.0, 0.0), (600.0, -500.0, 0.0), (-350.0, 500.0, 0.0))
)
TRACKER_AT = (2600.0, -700.0, 500.0)


class FakeClock:
    def __init__(self) -> None:
        self.time_s = 1000.0

    async def now_s(self) -> float:
        return self.time_s

    async def sleep(self, duration_s: float) -> None:
        self.time_s += duration_s


class FakeRobot(Controller):
    """Moves at once; notes every motion. `before_move` runs while the arm is about to move."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__()
        self._clock = clock
        self.joints = (0.0,) * 6
        self.faults: dict[int, DriverError] = {}  # number of the motion, from 0
        self.reading_age_s = 0.0
        self.misreport_rad = 0.0
        self.before_move: Callable[[], Awaitable[None]] | None = None
        self._attempts = 0

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        attempt, self._attempts = self._attempts, self._attempts + 1
        if self.before_move is not None:
            await self.before_move()
        self.moves.append(target_rad)
        if attempt in self.faults:
            fault = self.faults[attempt]
            self.connected = not isinstance(fault, ConnectionLostError)
            raise fault
        self.joints = target_rad
        self._clock.time_s += 1.5

    async def read_joints(self) -> JointReading:
        if not self.connected:
            raise ConnectionLostError("the robot's link is down")
        shown = (self.joints[0] + self.misreport_rad, *self.joints[1:])
        return JointReading(shown, math.radians(0.01), self._clock.time_s - self.reading_age_s)


@lru_cache(maxsize=8)  # a tracker that searches looks many times at an arm that stands still
def _nests_at(joints_rad: tuple[float, ...]) -> FloatArray:
    return np.array([nest_in_world(IRB120, FramePlacement(), NESTS, joints_rad, nest) for nest in (1, 2, 3)])


class FakeTracker(Device):
    """Sees the fixed nests and the reflectors on the arm, from a frame of its own."""

    def __init__(self, clock: FakeClock, robot: FakeRobot, *, azimuth_rad: float, noise_mm: float) -> None:
        super().__init__("Leica", "AT401", "390001", "3.8")
        self._clock = clock
        self._robot = robot
        self._rotation = rotation_xyz(0.005, -0.004, azimuth_rad)  # tracker to world
        self._noise_mm = noise_mm
        self._rng = np.random.default_rng(7)
        self._locked: int | None = None  # index into the reflectors
        self.at = np.array(TRACKER_AT)
        self.arm_error_mm = np.array([1.5, -2.0, 1.0])  # what calibration is there to find
        self.fixed_nests = np.array([nest.centre_mm for nest in FIXED_NESTS])
        self.initialised = 0
        self.face = 1
        self.settings = ""  # what it says that it measures with
        self.air: Environment | DriverError = Environment(23.1, 1013.0, 40.0)
        self.two_face_mm = 0.0
        self.blind = False
        self.faults: dict[int, DriverError] = {}  # number of the measurement, from 0
        self.find_faults: dict[int, DriverError] = {}
        self.shown: dict[int, TrackerReading] = {}  # readings to give instead of true ones
        self.finds = 0
        self.measurements = 0
        self.rms_mm = 0.02
        self.stated_mm = noise_mm or math.nan

    async def initialise(self) -> None:
        self.initialised += 1

    def in_tracker(self, world: FloatArray) -> FloatArray:
        return (world - self.at) @ self._rotation

    def _reflectors(self) -> FloatArray:
        return np.vstack([self.fixed_nests, _nests_at(tuple(self._robot.joints)) + self.arm_error_mm])

    async def find_reflector(self, near_mm: Vector, *, search_radius_mm: float) -> None:
        number, self.finds = self.finds, self.finds + 1
        self._clock.time_s += 1.0
        self._locked = None
        if number in self.find_faults:
            raise self.find_faults[number]
        places = self.in_tracker(self._reflectors())
        distances = np.linalg.norm(places - np.array(near_mm), axis=1)
        if self.blind or distances.min() > search_radius_mm:
            raise ReflectorNotFoundError("no reflector within the search radius")
        self._locked = int(distances.argmin())

    async def measure_point(self, *, duration_s: float) -> TrackerReading:
        number, self.measurements = self.measurements, self.measurements + 1
        self._clock.time_s += duration_s
        if number in self.faults:
            self.connected = not isinstance(self.faults[number], ConnectionLostError)
            raise self.faults[number]
        if number in self.shown:
            return self.shown[number]
        if self._locked is None:
            raise ReflectorNotFoundError("locked on nothing")
        return self._reading(self.in_tracker(self._reflectors())[self._locked])

    @property
    def on_the_arm(self) -> bool:
        return self._locked is not None and self._locked >= len(self.fixed_nests)

    def _reading(self, place: FloatArray) -> TrackerReading:
        place = place + self._noise_mm * self._rng.standard_normal(3)
        place = place + np.array([0.0, 0.0, self.two_face_mm if self.face == 1 else -self.two_face_mm])
        x, y, z = (float(value) for value in place)
        stated = (self.stated_mm,) * 3
        return TrackerReading((x, y, z), stated, self.rms_mm, 100, 1.0, self.face, self._clock.time_s)

    async def reflector_now(self) -> Vector | None:
        return None

    async def change_face(self) -> None:
        self.face = 3 - self.face

    async def environment(self) -> Environment:
        if isinstance(self.air, DriverError):
            raise self.air
        return self.air


class ListLedger(FiniteDisk):
    """Keeps lines, and tells what they say of each kind; `before` is done before a line is kept."""

    def __init__(self) -> None:
        super().__init__()
        self.entries: list[LedgerEntry] = []
        self.before: Callable[[LedgerEntry], Awaitable[None]] | None = None
        self.full_disk_at: int | None = None  # number of the reading that cannot be kept
        self.refused = asyncio.Event()

    def make_room(self) -> None:
        self.refused.clear()
        super().make_room()

    async def append(self, entry: LedgerEntry) -> int:
        if self.full:
            self.refused.set()
            raise RecordRefusedError("database or disk is full")
        if entry.point is not None and self.full_disk_at == len(self.points):
            raise OSError("no space left on the disk")
        if self.before is not None:
            await self.before(entry)
        self.entries.append(entry)
        return len(self.entries)

    def _told(self, name: str) -> list[Any]:
        return [said for entry in self.entries if (said := getattr(entry, name)) is not None]

    @property
    def states(self) -> list[tuple[SessionState, str, str | None]]:
        return [(e.entered, english(e.text), e.person) for e in self.entries if e.entered is not None]

    @property
    def points(self) -> list[PointTaken]:
        return self._told("point")

    @property
    def fixed(self) -> list[FixedNestTaken]:
        return self._told("fixed_nest")

    @property
    def registrations(self) -> list[Registration]:
        return self._told("registration")

    @property
    def identities(self) -> list[IdentityTaken]:
        return self._told("identity")

    @property
    def progress(self) -> list[Progress]:
        return self._told("progress")

    @property
    def skipped(self) -> list[StopSkipped]:
        lines = [entry for entry in self.entries if entry.kind is EntryKind.SKIPPED]
        return [StopSkipped(config_of(e.step_id), e.time_s, english(e.text)) for e in lines]

    @property
    def notes(self) -> list[str]:
        return [english(entry.text) for entry in self.entries if entry.kind is EntryKind.NOTED]


class FakeCell:
    """Everything together; `cell` is what the session gets to know of it."""

    def __init__(self, *, azimuth_rad: float = 2.0, noise_mm: float = 0.0) -> None:
        self.clock = FakeClock()
        self.robot = FakeRobot(self.clock)
        self.tracker = FakeTracker(self.clock, self.robot, azimuth_rad=azimuth_rad, noise_mm=noise_mm)
        self.journal = ListLedger()
        self.cell = SessionCell(
            tracker=self.tracker,
            robot_controller=self.robot,
            clock=self.clock,
            robot=IRB120,
            base=FramePlacement(),
            nests=NESTS,
            fixed_nests=FIXED_NESTS,
            look_at_ways=nothing_in_the_way,
            tracker_position_mm=TRACKER_AT,
        )


def make_stop(config: int, nest: int = 1, repeat_of: int | None = None) -> PlannedStop:
    """A stop somewhere in the ranges; the same number gives the same joints."""
    rng = np.random.default_rng(repeat_of or config)
    low = np.array([limit.lower_rad for limit in IRB120.calibration_ranges])
    high = np.array([limit.upper_rad for limit in IRB120.calibration_ranges])
    joints = low + (high - low) * rng.random(6)
    return PlannedStop(config, tuple(float(joint) for joint in joints), nest, repeat_of)


def make_plan(n_stops: int = 3, **changes: object) -> SessionPlan:
    """A short plan: five registration readings are as good as twenty where nothing scatters."""
    stops = tuple(make_stop(config) for config in range(1, n_stops + 1))
    values = {"role": "calibration", "stops": stops, "registration_readings": 5} | changes
    return SessionPlan(**values)  # type: ignore[arg-type]
