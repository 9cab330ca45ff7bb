"""The arm as a session moves it: the one call of `move_joints`, behind the interlocks, in pieces.

Where a protocol cannot stop a motion, whatever was sent last is gone through to its end: when this program
is killed, and when somebody asks for a pause. Pieces make that short. They lie on one line of the joints,
so the arm takes the same way and comes to every stop from the same side.
"""

import asyncio
import math
import time
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose.domain.session import SessionState, Vector
from truepose.kinematics.frames import vector_from_rotation
from truepose.messages.message import Text, message
from truepose.sessions.engine.interlocks import (
    MAX_STATE_AGE_S,
    MotionConditions,
    motion_obstacle,
)
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose.sessions.engine.ways import Joints, KnownWays, LookAtWays, apart, are_comparable
from truepose.sessions.errors import MotionForbiddenError
from truepose_drivers.api import Clock, FullRobot, JointReading, MotionLimits
from truepose_drivers.errors import TargetRefusedError

_LOOKS: Final = 24  # along a way; between two of them the speeds hardly change
_LONG_S: Final = 0.5  # of cell time, after which one can tell whether it costs wall time
_SHARE_THAT_WAITS: Final = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmCell:
    """The robot of one cell, and what binds its motions."""

    robot_controller: FullRobot
    clock: Clock
    robot: Robot  # nominal
    look_at_ways: LookAtWays  # before the arm goes them
    joint_limits: tuple[JointRange, ...] | None = None  # what no motion may leave
    speed_limits: MotionLimits | None = None  # above which nothing moves, whatever the plan says


class MotionSegments:
    """Cuts motions of one robot at one speed, which its controller keeps at a point of the flange's frame."""

    def __init__(self, robot: Robot, speed: MotionLimits, point_mm: Vector = (0.0, 0.0, 0.0)) -> None:
        self._robot = robot
        self._speed = speed
        self._point_mm = np.array(point_mm)

    def of(
        self, start_rad: Joints, target_rad: Joints, longest_s: float, takes_s: float = 0.0
    ) -> Iterator[Joints]:
        """Yield where the pieces of a straight joint motion end, the target last.

        The way q(s) = start + s (target - start) is looked at in 24 equal steps. The slowest of them takes
        t = max(path / tool speed, turn / orientation speed), so that ceil(24 t / longest) equal pieces take
        `longest_s` each at most, at the speed of this object; so do ceil(takes_s / longest).

        Parameters
        ----------
        start_rad, target_rad : tuple of float
            Joint angles [rad].
        longest_s : float
            What a piece may take [s], above 0.
        takes_s : float
            What the controller says that the whole takes [s], all joints turning evenly; 0: it says nothing.

        Yields
        ------
        tuple of float
            Joint angles at the end of a piece [rad].
        """
        # By the slowest step and not by the whole: equal shares of the joints are no equal times where the
        # arm stretches or turns its wrist.
        slowest_s = self._slowest_look_s(np.array(start_rad), np.array(target_rad))
        count = math.ceil(max(_LOOKS * slowest_s, takes_s) / longest_s)
        for piece in range(1, count):
            yield tuple(a + (b - a) * piece / count for a, b in zip(start_rad, target_rad, strict=True))
        yield target_rad

    def _slowest_look_s(self, start: FloatArray, target: FloatArray) -> float:
        """Return the longest time between two of the equal steps of the joints [s].

        start, target : ndarray, shape (J,), joint angles [rad].
        """
        share = np.linspace(0.0, 1.0, _LOOKS + 1)[:, None]
        # In the robot's own base: lengths and angles are the same wherever it stands.
        chain = nominal_chain(self._robot, FramePlacement(), start + share * (target - start))
        last = chain.rotation[-1]
        path_mm = np.linalg.norm(np.diff(chain.points(self._point_mm), axis=0), axis=1)
        turn_rad = np.linalg.norm(vector_from_rotation(np.swapaxes(last[:-1], -1, -2) @ last[1:]), axis=1)
        speed = self._speed
        # A controller keeps both limits, so the one that takes longer binds.
        times = np.maximum(path_mm / speed.tool_speed_mm_s, turn_rad / speed.orientation_speed_rad_s)
        return float(times.max())


class WallPace:
    """Whether motions take wall time: in a simulated cell they may not, and then nothing interrupts them."""

    def __init__(self, wall_s: Callable[[], float]) -> None:
        self._wall_s = wall_s
        self._began: tuple[float, float] | None = None  # cell time, wall time
        self.waits = True  # until the contrary was seen; in a real cell the two times are one

    def look(self, cell_s: float) -> None:
        """Compare how far the cell's time and that of the wall have gone since the first look."""
        wall_s = self._wall_s()
        if self._began is None:
            self._began = cell_s, wall_s
        gone_s = cell_s - self._began[0]
        # Over less the clocks' own resolution would decide.
        if gone_s > _LONG_S:
            self.waits = wall_s - self._began[1] > _SHARE_THAT_WAITS * gone_s

    def begin_anew(self) -> None:
        """Forget when the first look was: a person may have had hours since."""
        self._began = None


@dataclass(frozen=True, slots=True)
class Permission:
    """What the session says at this moment about motion."""

    state: SessionState
    stop_requested: bool
    question: Text | None
    obstacle: Text | None = None  # anything else that forbids motion, as a sentence


_LOOK_TWICE_S: Final = 0.5  # between two looks; 0.02 deg/s is then seen in a reply rounded to 0.01 deg

AskPermission: TypeAlias = Callable[[float], Permission]  # at a cell time
BeforePiece: TypeAlias = Callable[[], Awaitable[None]]  # lets what the permission rests on be read anew


class Arm:
    """Moves the robot where the session allows it, by known ways; knows where it ended, from which side."""

    def __init__(
        self,
        controller: FullRobot,
        clock: Clock,
        robot: Robot,
        limits: tuple[JointRange, ...],
        tolerance_rad: float,
        ask_permission: AskPermission,
        ways: KnownWays,
        max_state_age_s: float = MAX_STATE_AGE_S,
        wall_s: Callable[[], float] = time.monotonic,
        before_piece: BeforePiece | None = None,
    ) -> None:
        self._controller = controller
        self._clock = clock
        self._robot = robot
        self._limits = limits
        self._tolerance_rad = tolerance_rad
        self._ask_permission = ask_permission
        self._max_state_age_s = max_state_age_s
        self._segments = MotionSegments(robot, MotionLimits())  # the speed that drivers begin with
        self._pace = WallPace(wall_s)
        self._ways = ways
        self._before_piece = before_piece
        self._left_at: tuple[float, ...] | None = None
        self._direction = (0,) * len(limits)

    @property
    def direction(self) -> tuple[int, ...]:
        """Sign of each joint's last motion; 0 where this session has not moved it yet."""
        return self._direction

    def forget(self) -> None:
        """Forget where the arm was left: a person had it since, and confirmed where it stands now."""
        self._left_at = None
        self._direction = (0,) * len(self._limits)
        self._pace.begin_anew()

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed of the motions that follow; raises the driver's errors."""
        await self._controller.set_limits(limits)
        # Cut for the speed in force, whatever a session set before: what is cut for 250 mm/s takes 25 times
        # as long at the 10 mm/s at which a probe leaves its target.
        point_mm = self._controller.motion_guard.speed_point_mm
        self._segments = MotionSegments(self._robot, limits, point_mm)

    async def read(self) -> JointReading:
        """Ask where the joints are."""
        return await self._controller.read_joints()

    async def move(self, target_rad: tuple[float, ...]) -> bool:
        """Move to `target_rad` and come to rest; raises MotionForbiddenError and the driver's errors.

        Returns whether the way there was none that the session knew, so that it was looked at now.
        What the controller cannot stop goes out in pieces; before each of them everything is asked again.
        """
        # After a lost link, a restart or a person's hand nobody knows whether a motion is still under way,
        # and one statement of the joints shows no motion.
        here = await self._at_rest() if self._left_at is None else None
        is_new = await self._require_way(here, target_rad)
        reading = await self._read_in_time()
        share, pieces = self._speed_share, self._pieces_to(target_rad, reading)
        while (piece_rad := next(pieces)) != target_rad:
            await self._move_piece(piece_rad, target_rad, reading)
            # What the permission rests on grows old while a piece is under way: a piece may last longer
            # than a sample of the ballbar counts (commit 5dc5fb9a).
            if self._before_piece is not None:
                await self._before_piece()
            reading = await self._read_in_time()
            # The rest is cut anew where somebody has turned the speed override meanwhile.
            if self._speed_share != share:
                share, pieces = self._speed_share, self._pieces_to(target_rad, reading)
        await self._move_piece(target_rad, target_rad, reading)
        return is_new

    async def _require_way(self, here: JointReading | None, target_rad: Joints) -> bool:
        """See that the way to a target was looked at, or look at it now; raises WayNotClearError."""
        start_rad, allowed_rad = self._left_at, self._tolerance_rad
        if here is not None:
            start_rad, allowed_rad = here.joints_rad, allowed_rad + here.resolution_rad
        # What cannot be looked at is refused by the interlocks.
        if start_rad is None or not are_comparable(start_rad, target_rad):
            return False
        return await self._ways.require(start_rad, target_rad, allowed_rad)

    @property
    def _speed_share(self) -> float:
        """Of the limits, as the speed override leaves it; one that is not told is taken for 100 %."""
        return self._controller.motion_guard.speed_share or 1.0

    def _pieces_to(self, target_rad: Joints, reading: JointReading) -> Iterator[Joints]:
        # Where the arm was left is exact; what it reports is rounded, and pieces from there would not lie on
        # the planned line.
        start_rad = self._left_at or reading.joints_rad
        guard = self._controller.motion_guard
        longest_s = guard.longest_piece_s
        known = are_comparable(start_rad, target_rad)
        # What is not known is not cut but judged as it is: the interlocks below refuse a target with other
        # joints, or one that is no number.
        if longest_s is None or not known or not self._pace.waits:
            return iter((target_rad,))
        # A controller that knows speeds of joints only goes more slowly than the limits let it.
        takes_s = 0.0 if guard.takes_s is None else guard.takes_s(start_rad, target_rad)
        return self._segments.of(start_rad, target_rad, longest_s * self._speed_share, takes_s)

    async def _move_piece(self, piece_rad: Joints, target_rad: Joints, reading: JointReading) -> None:
        now_s = await self._clock.now_s()
        self._pace.look(now_s)
        # nothing is awaited between the last look at the session's state and the motion
        self._require_permission(target_rad, reading, now_s)
        # Forgotten first, remembered after the reply: a motion that ends in an error has ended somewhere.
        before = self._left_at
        self._left_at = None
        try:
            await self._controller.move_joints(piece_rad)
        # The controller looked at the target and began nothing, so the arm is where it was.
        except TargetRefusedError:
            self._left_at = before
            raise
        self._left_at = piece_rad
        # a reported angle is rounded: a smaller difference to it says nothing of the sign
        smallest_rad = reading.resolution_rad if before is None else 0.0
        came_from = reading.joints_rad if before is None else before
        # Gears have backlash, so that a reading has to say from which side each joint came; a session that
        # does not know says 0.
        self._direction = _direction(came_from, piece_rad, self._direction, smallest_rad)

    async def _read_in_time(self) -> JointReading:
        """Ask where the joints are; what was under way for too long says nothing of now."""
        try:
            # A statement that came late passes for a new one by its time stamp where the driver stamps
            # answers at their arrival (commit ebc48e23).
            async with asyncio.timeout(self._max_state_age_s):
                return await self.read()
        except TimeoutError as error:
            raise MotionForbiddenError(
                message("session.joints.late", limit_s=self._max_state_age_s)
            ) from error

    async def _at_rest(self) -> JointReading:
        """Look twice where nobody knows how the arm came here: a lost motion may still be under way."""
        before = await self.read()
        await self._clock.sleep(_LOOK_TWICE_S)
        after = await self.read()
        # Not the opposite comparison: an angle that is no number is not at rest.
        if not apart(before.joints_rad, after.joints_rad) <= after.resolution_rad:
            raise MotionForbiddenError(message("session.still_moving"))
        return after

    def _require_permission(self, target_rad: tuple[float, ...], reading: JointReading, now_s: float) -> None:
        permission = self._ask_permission(now_s)
        conditions = MotionConditions(
            state=permission.state,
            stop_requested=permission.stop_requested,
            question=permission.question,
            robot_connected=self._controller.connected,
            reading=reading,
            now_s=now_s,
            left_at_rad=self._left_at,
            tolerance_rad=self._tolerance_rad,
            obstacle=permission.obstacle,
            max_state_age_s=self._max_state_age_s,
        )
        forbidden = motion_obstacle(conditions, target_rad, self._limits)
        if forbidden is not None:
            raise MotionForbiddenError(forbidden)


def _direction(
    came_from: tuple[float, ...], target: tuple[float, ...], before: tuple[int, ...], smallest_rad: float
) -> tuple[int, ...]:
    """Return the sign of each joint's last motion; one that stood still keeps that of its motion before."""
    return tuple(
        earlier if abs(to - start) <= smallest_rad else (1 if to > start else -1)
        for start, to, earlier in zip(came_from, target, before, strict=True)
    )
