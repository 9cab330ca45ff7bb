"""The arm as the session moves it: the one call of `move_joints`, behind the interlocks."""

import asyncio
import math
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose.domain.measurement.session import SessionState
from truepose.domain.robot import JointRange
from truepose.sequencing.engine.motion.interlocks import (
    MAX_STATE_AGE_S,
    MotionConditions,
    what_forbids_motion,
)
from truepose.sequencing.engine.motion.segments import Joints, MotionSegments, WallPace
from truepose.sequencing.errors import MotionForbiddenError
from truepose_drivers.api import Clock, FullRobot, JointReading
from truepose_drivers.errors import TargetRefusedError


@dataclass(frozen=True, slots=True)
class Permission:
    """What the session says at this moment about motion."""

    state: SessionState
    stop_requested: bool
    question: str | None
    obstacle: str | None = None  # anything else that forbids motion, as a sentence


_LOOK_TWICE_S: Final = 0.5  # between two looks; 0.02 deg/s is then seen in a reply rounded to 0.01 deg

AskPermission: TypeAlias = Callable[[float], Permission]  # at a cell time
BeforePiece: TypeAlias = Callable[[], Awaitable[None]]  # lets what the permission rests on be read anew


class Arm:
    """Moves the robot where the session allows it; knows where the last motion ended, from which side."""

    def __init__(
        self,
        controller: FullRobot,
        clock: Clock,
        limits: tuple[JointRange, ...],
        tolerance_rad: float,
        ask_permission: AskPermission,
        max_state_age_s: float = MAX_STATE_AGE_S,
        pieces: MotionSegments | None = None,
        wall_s: Callable[[], float] = time.monotonic,
        before_piece: BeforePiece | None = None,
    ) -> None:
        self._controller = controller
        self._clock = clock
        self._limits = limits
        self._tolerance_rad = tolerance_rad
        self._ask_permission = ask_permission
        self._max_state_age_s = max_state_age_s
        self._pieces = pieces
        self._pace = WallPace(wall_s)
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

    async def read(self) -> JointReading:
        """Ask where the joints are."""
        return await self._controller.read_joints()

    async def move(self, target_rad: tuple[float, ...]) -> None:
        """Move to `target_rad` and come to rest; raises MotionForbiddenError and the driver's errors.

        What the controller cannot stop goes out in pieces; before each of them everything is asked again.
        """
        if self._left_at is None:
            await self._require_rest()
        reading = await self._read_in_time()
        for number, piece_rad in enumerate(self._pieces_to(target_rad, reading)):
            if number > 0:
                if self._before_piece is not None:
                    await self._before_piece()
                reading = await self._read_in_time()
            await self._move_piece(piece_rad, target_rad, reading)

    def _pieces_to(self, target_rad: Joints, reading: JointReading) -> tuple[Joints, ...]:
        start_rad = self._left_at or reading.joints_rad
        longest_s = self._controller.motion_guard.longest_piece_s
        known = len(start_rad) == len(target_rad) and all(map(math.isfinite, (*start_rad, *target_rad)))
        if self._pieces is None or longest_s is None or not known or not self._pace.waits:
            return (target_rad,)
        return self._pieces.of(start_rad, target_rad, longest_s)

    async def _move_piece(self, piece_rad: Joints, target_rad: Joints, reading: JointReading) -> None:
        now_s = await self._clock.now_s()
        self._pace.look(now_s)
        # nothing is awaited between the last look at the session's state and the motion
        self._require_permission(target_rad, reading, now_s)
        before = self._left_at
        self._left_at = None
        try:
            await self._controller.move_joints(piece_rad)
        except TargetRefusedError:
            self._left_at = before
            raise
        self._left_at = piece_rad
        # a reported angle is rounded: a smaller difference to it says nothing of the sign
        smallest_rad = reading.resolution_rad if before is None else 0.0
        came_from = reading.joints_rad if before is None else before
        self._direction = _direction(came_from, piece_rad, self._direction, smallest_rad)

    async def _read_in_time(self) -> JointReading:
        """Ask where the joints are; what was under way for too long says nothing of now."""
        try:
            async with asyncio.timeout(self._max_state_age_s):
                return await self.read()
        except TimeoutError as error:
            raise MotionForbiddenError(
                f"The robot took more than {self._max_state_age_s:g} s to state its joints; nothing moves."
            ) from error

    async def _require_rest(self) -> None:
        """Look twice where nobody knows how the arm came here: a lost motion may still be under way."""
        before = await self.read()
        await self._clock.sleep(_LOOK_TWICE_S)
        after = await self.read()
        pairs = zip(before.joints_rad, after.joints_rad, strict=False)
        if any(abs(second - first) > after.resolution_rad for first, second in pairs):
            raise MotionForbiddenError("The arm is still moving; nothing is sent before it is at rest.")

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
        forbidden = what_forbids_motion(conditions, target_rad, self._limits)
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
