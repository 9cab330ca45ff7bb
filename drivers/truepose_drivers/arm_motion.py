"""What drivers of arms share in a motion: its target, an arm that stands still, a protocol that watches.

A stop leaves some controllers silent, and at a low speed override a motion may take minutes. Whoever tells
the joints meanwhile shows the difference. Joints that are not between start and target are not those of this
motion: they come from a channel that tells what was, and prove nothing.
"""

import asyncio
import contextlib
import math
import sys
from collections.abc import Awaitable, Callable, Coroutine, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol, TypeAlias, TypeVar

from truepose_drivers.api import (
    DeviceIdentity,
    FullRobot,
    JointReading,
    MotionGuard,
    MotionLimits,
)
from truepose_drivers.arm_options import Angles
from truepose_drivers.errors import (
    ConfigurationError,
    ConnectionLostError,
    DriverError,
    LinkError,
    NoReplyError,
    TargetRefusedError,
)
from truepose_drivers.transports.link import now_s

ARRIVED_DEG: Final = 0.02  # a joint at rest is nearer to its target: encoders resolve far better


def require_speeds(limits: MotionLimits, fastest: float = sys.float_info.max) -> None:
    """Raise ConfigurationError for a speed limit that is none, or above what the controller can hold."""
    for name, value in (
        ("tool_speed_mm_s", limits.tool_speed_mm_s),
        ("orientation_speed_rad_s", limits.orientation_speed_rad_s),
    ):
        # Written as "not within": a NaN compares false with everything and would pass any test for what is
        # wrong.
        if not 0.0 < value <= fastest:  # nor where it is no number
            raise ConfigurationError(f"{name} is {value}: a speed limit must be positive")


def require_target(target_rad: Angles, joints: int, furthest_rad: float = math.inf) -> None:
    """Raise TargetRefusedError for a target of other joints, or out of the range of any."""
    if len(target_rad) != joints:
        raise TargetRefusedError(f"the robot moves {joints} joints; the target has {len(target_rad)}")
    for joint, angle in enumerate(target_rad, start=1):
        if not abs(angle) <= furthest_rad:  # nor where it is no number
            raise TargetRefusedError(
                f"{math.degrees(angle)} deg of joint {joint} is out of any robot's range"
            )


def farthest_off(stands: Sequence[float], target: Sequence[float]) -> float:
    """Return by how much that joint is off its target that is off most; in the unit of both."""
    return max(abs(here - there) for here, there in zip(stands, target, strict=True))


def degrees_text(angles_deg: Sequence[float]) -> str:
    """Return angles as a sentence has them."""
    return ", ".join(f"{angle:.3f}" for angle in angles_deg)


def target_refused(target_deg: Sequence[float], rest: str = "") -> TargetRefusedError:
    """Return the error of a robot that does not take a target; `rest` says why, or what to do."""
    return TargetRefusedError(f"the robot refused the joint target ({degrees_text(target_deg)}) deg{rest}")


def stopped_unheard(silence_s: float) -> ConnectionLostError:
    """Return the error of a program that stopped the arm because nobody was heard for so long [s]."""
    return ConnectionLostError(
        f"the robot stopped during the motion because it received nothing for {silence_s:g} s: check the"
        " network, then confirm before anything moves"
    )


@contextlib.contextmanager
def motion_awaited(advice: str, why_it_hangs_up: str = "") -> Iterator[None]:
    """Say of a link that is lost here that it was during a motion, and with `advice` what to do."""
    try:
        yield
    except NoReplyError as error:
        raise NoReplyError(f"the robot did not report the end of its motion: {advice}") from error
    except ConnectionLostError as error:
        raise ConnectionLostError(
            f"the robot closed the connection during a motion{why_it_hangs_up}: {advice}"
        ) from error


_LOOK_EVERY_S: Final = 0.5  # wall time, as all here
_STANDS_AFTER_S: Final = 3.0
_BEGINS_WITHIN_S: Final = 5.0  # of the order: brakes open, programs start
_BESIDE_THE_WAY_DEG: Final = 1.0  # joints brake neither at once nor exactly in step

Look: TypeAlias = Callable[[], Awaitable[Angles | None]]
Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class CommandedMotion:
    """A motion, as its controller counts joints [deg]."""

    start_deg: Angles
    target_deg: Angles
    arrived_deg: float  # a joint at rest is nearer to its target
    still_deg: float  # what is told of a joint at rest changes by no more

    def before_target_deg(self, joints_deg: Angles) -> float:
        """Return how far the joint has still to turn that has farthest."""
        return farthest_off(joints_deg, self.target_deg)

    def leads_by(self, joints_deg: Angles) -> bool:
        """Whether an arm on this motion can be there."""
        return all(
            min(ends) - _BESIDE_THE_WAY_DEG <= joint <= max(ends) + _BESIDE_THE_WAY_DEG
            for joint, *ends in zip(joints_deg, self.start_deg, self.target_deg, strict=True)
        )


class Standstill:
    """Judges one look at the joints after the other; times on any clock that goes with the arm [s]."""

    def __init__(self, course: CommandedMotion, ordered_s: float) -> None:
        self._course = course
        self._stands_deg = course.start_deg
        self._since_s = ordered_s
        self._patience_s = _BEGINS_WITHIN_S

    def lasts(self, joints_deg: Angles, now_s: float) -> bool:
        """Take a look into account; return whether the arm stands still before its target."""
        # A logger that tells old joints, or those of another arm, must not end a motion that goes well.
        if not self._course.leads_by(joints_deg):
            return False
        # Compared with where it stood first, not with the last look: slow motion adds up.
        if farthest_off(joints_deg, self._stands_deg) > self._course.still_deg:
            self._stands_deg, self._since_s, self._patience_s = joints_deg, now_s, _STANDS_AFTER_S
        return now_s - self._since_s >= self._patience_s and self._is_before_target()

    def _is_before_target(self) -> bool:
        return self._course.before_target_deg(self._stands_deg) > self._course.arrived_deg


async def answered_unless_it_stands(
    motion: Coroutine[Any, Any, Answer], look: Look, course: CommandedMotion, advice: str
) -> Answer:
    """Return what a motion ends with; `look` returns the joints meanwhile, None where nobody tells them.

    Where the arm stands still the motion is cancelled, which closes its link: a program that watches it gives
    the motion up then, so that nothing goes on when the stop is released. Raises NoReplyError.
    """
    # No time limit instead: only the controller knows how long a motion takes under somebody's speed
    # override, and only the joints tell a stop from a slow motion.
    answered = asyncio.create_task(motion)
    watched = asyncio.create_task(_stands_before_target_deg(look, course))
    try:
        await asyncio.wait({answered, watched}, return_when=asyncio.FIRST_COMPLETED)
        # Asked first, since both may have ended in one turn of the loop: an answer that came counts.
        if answered.done():
            return answered.result()
        raise NoReplyError(f"the arm stopped {watched.result():.2f} deg before its target: {advice}")
    finally:
        answered.cancel()
        watched.cancel()
        # Waited for: the cancelled conversation closes its link on its way out, and whoever catches the error
        # may connect again at once.
        await asyncio.wait({answered, watched})


async def _stands_before_target_deg(look: Look, course: CommandedMotion) -> float:
    standstill = Standstill(course, now_s())
    while True:
        await asyncio.sleep(_LOOK_EVERY_S)
        joints_deg = await look()
        if joints_deg is not None and standstill.lasts(joints_deg, now_s()):
            return course.before_target_deg(joints_deg)


_BETWEEN_LOOKS_S: Final = 0.3  # at whether the arm can still move, while it does


class Companion(Protocol):
    """A second connection to the controller of a robot, which moves nothing."""

    @property
    def connected(self) -> bool:
        """Whether it is there as far as known."""
        ...

    async def connect(self) -> None:
        """Open it; raises ConnectFailedError."""
        ...

    async def close(self) -> None:
        """Close it; never raises."""
        ...

    async def require_ready(self) -> None:
        """Raise NotInitialisedError where the arm cannot move, by what the controller states now."""
        ...

    async def read_joints(self) -> JointReading:
        """Ask where the joints are."""
        ...

    @property
    def speed_share(self) -> float | None:
        """Of the limits, as the speed override leaves it, by what was stated last; None: it is not told."""
        ...

    async def last_words(self) -> str:
        """Return what the controller said last to people, empty where that is not known."""
        ...


class AccompaniedRobot:
    """A robot whose companion reads the joints, and which moves only where that says that it can."""

    def __init__(self, robot: FullRobot, companion: Companion) -> None:
        self._robot = robot
        self._companion = companion

    @property
    def connected(self) -> bool:
        """Whether both are there as far as known."""
        return self._robot.connected and self._companion.connected

    @property
    def can_stop_motion(self) -> bool:
        """What the protocol says that moves it."""
        return self._robot.can_stop_motion

    @property
    def motion_guard(self) -> MotionGuard:
        """What the protocol says that moves it, with the speed override where the companion tells it."""
        guard = self._robot.motion_guard
        return replace(guard, speed_share=self._companion.speed_share or guard.speed_share)

    async def connect(self) -> None:
        """Connect both; raises ConnectFailedError."""
        await self._robot.connect()
        try:
            await self._companion.connect()
        except DriverError:
            # Otherwise the one half that is open would keep the controller's only place for a client.
            await self._robot.close()
            raise

    async def close(self) -> None:
        """Close both; never raises."""
        await self._companion.close()
        await self._robot.close()

    async def identify(self) -> DeviceIdentity:
        """Ask the protocol that moves it."""
        return await self._robot.identify()

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed limits of the following motions."""
        await self._robot.set_limits(limits)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move where the controller is ready now; raises NotInitialisedError, TargetRefusedError."""
        await self._companion.require_ready()
        # The protocol that moves the arm may have no words for errors: open_abb just never answers with
        # motors off or in an emergency stop (abb-open-abb.md, "Reply"). The companion knows, and is asked
        # before and during.
        motion = asyncio.create_task(self._robot.move_joints(target_rad))
        try:
            while not (await asyncio.wait({motion}, timeout=_BETWEEN_LOOKS_S))[0]:
                await self._companion.require_ready()
            motion.result()
        except (LinkError, TargetRefusedError) as error:
            # Of the same class: what a caller does about the fault does not depend on what the event log
            # adds.
            raise type(error)(f"{error}{await self._said()}") from error
        finally:
            motion.cancel()
            await asyncio.wait({motion})

    async def read_joints(self) -> JointReading:
        """Return where the joints are, by the companion; also while the arm moves."""
        return await self._companion.read_joints()

    async def _said(self) -> str:
        try:
            said = await self._companion.last_words()
        except DriverError:
            return ""
        return f' (its event log ends with "{said}")' if said else ""
