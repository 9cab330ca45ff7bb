"""An arm that stands still on its way while the reply to its motion is awaited: told within seconds.

A stop leaves some controllers silent, and at a low speed override a motion may take minutes. Whoever tells
the joints meanwhile shows the difference. Joints that are not between start and target are not those of this
motion: they come from a channel that tells what was, and prove nothing.
"""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, TypeVar

from truepose_drivers.errors import NoReplyError

_LOOK_EVERY_S: Final = 0.5  # wall time, as all here
_STANDS_AFTER_S: Final = 3.0
_BEGINS_WITHIN_S: Final = 5.0  # of the order: brakes open, programs start
_BESIDE_THE_WAY_DEG: Final = 1.0  # joints brake neither at once nor exactly in step

Angles: TypeAlias = tuple[float, ...]
Look: TypeAlias = Callable[[], Awaitable[Angles | None]]
Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class Course:
    """A motion, as its controller counts joints [deg]."""

    start_deg: Angles
    target_deg: Angles
    arrived_deg: float  # a joint at rest is nearer to its target
    still_deg: float  # what is told of a joint at rest changes by no more

    def before_target_deg(self, joints_deg: Angles) -> float:
        """Return how far the joint has still to turn that has farthest."""
        return _farthest(joints_deg, self.target_deg)

    def leads_by(self, joints_deg: Angles) -> bool:
        """Whether an arm on this motion can be there."""
        return all(
            min(ends) - _BESIDE_THE_WAY_DEG <= joint <= max(ends) + _BESIDE_THE_WAY_DEG
            for joint, *ends in zip(joints_deg, self.start_deg, self.target_deg, strict=True)
        )


class Standstill:
    """Judges one look at the joints after the other; times on any clock that goes with the arm [s]."""

    def __init__(self, course: Course, ordered_s: float) -> None:
        self._course = course
        self._stands_deg = course.start_deg
        self._since_s = ordered_s
        self._patience_s = _BEGINS_WITHIN_S

    def lasts(self, joints_deg: Angles, now_s: float) -> bool:
        """Take a look into account; return whether the arm stands still before its target."""
        if not self._course.leads_by(joints_deg):
            return False
        # Compared with where it stood first, not with the last look: slow motion adds up.
        if _farthest(joints_deg, self._stands_deg) > self._course.still_deg:
            self._stands_deg, self._since_s, self._patience_s = joints_deg, now_s, _STANDS_AFTER_S
        return now_s - self._since_s >= self._patience_s and self._is_before_target()

    def _is_before_target(self) -> bool:
        return self._course.before_target_deg(self._stands_deg) > self._course.arrived_deg


async def answered_unless_it_stands(
    motion: Coroutine[Any, Any, Answer], look: Look, course: Course, advice: str
) -> Answer:
    """Return what a motion ends with; `look` returns the joints meanwhile, None where nobody tells them.

    Where the arm stands still the motion is cancelled, which closes its link: a program that watches it gives
    the motion up then, so that nothing goes on when the stop is released. Raises NoReplyError.
    """
    answered = asyncio.create_task(motion)
    watched = asyncio.create_task(_stands_before_target_deg(look, course))
    try:
        await asyncio.wait({answered, watched}, return_when=asyncio.FIRST_COMPLETED)
        if answered.done():
            return answered.result()
        raise NoReplyError(f"the arm stands still {watched.result():.2f} deg before its target: {advice}")
    finally:
        answered.cancel()
        watched.cancel()
        await asyncio.wait({answered, watched})


async def _stands_before_target_deg(look: Look, course: Course) -> float:
    loop = asyncio.get_running_loop()
    standstill = Standstill(course, loop.time())
    while True:
        await asyncio.sleep(_LOOK_EVERY_S)
        joints_deg = await look()
        if joints_deg is not None and standstill.lasts(joints_deg, loop.time()):
            return course.before_target_deg(joints_deg)


def _farthest(joints_deg: Angles, others_deg: Angles) -> float:
    return max(abs(joint - other) for joint, other in zip(joints_deg, others_deg, strict=True))
