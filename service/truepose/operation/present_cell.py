"""The cell as it is now, against what was stored with a session: what binds a motion is the tighter of both.

A session keeps the cell it was planned in, because its readings belong to that. What the arm may do is
another matter: whoever tightens a limit in the cell file means every motion from then on.
"""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from truepose.domain.cell.description import Cell, CellLimits
from truepose.domain.errors import TrueposeError
from truepose.domain.robot import JointRange
from truepose.operation.errors import CellChangedError
from truepose.sequencing.engine.identity.expected import same_number
from truepose.sequencing.engine.motion.limits import common_ranges, slowest
from truepose.sequencing.engine.prompts import require_announced
from truepose.sequencing.errors import PlanRefusedError
from truepose_drivers.api import MotionLimits

ReadCell: TypeAlias = Callable[[], Cell]


class PresentCell:
    """The cell that the service was started with, and whether its file still says the same.

    Without a cell only what was stored with a session binds its motions.
    """

    def __init__(self, cell: Cell | None = None, read_again: ReadCell | None = None) -> None:
        self._cell = cell
        self._read_again = read_again

    @property
    def people(self) -> tuple[str, ...]:
        """Who may have the arm move; empty: whoever gives a name."""
        return () if self._cell is None else self._cell.people

    async def require_unchanged(self) -> None:
        """Raise CellChangedError where the cell file does not say what the service was started with."""
        if self._read_again is None:
            return
        try:
            found = await asyncio.to_thread(self._read_again)
        except TrueposeError as error:
            raise CellChangedError(
                f"The cell file cannot be read any more ({error}). Nothing moves by the old one: put the "
                "file right, then restart the service."
            ) from error
        if found != self._cell:
            raise CellChangedError(
                "The cell file has changed since the service was started. Nothing moves by the old one: "
                "restart the service, so that the new one counts, then confirm again."
            )

    def require_person(self, person: str) -> str:
        """Return the name of somebody who may have the arm move.

        Raises PersonMissingError, PersonUnknownError.
        """
        return require_announced(person, self.people)

    def require_same_robot(self, stored: Cell) -> None:
        """Raise PlanRefusedError where a session was planned for a robot of another serial number."""
        present = "" if self._cell is None else self._cell.robot_serial_number
        planned = stored.robot_serial_number
        if present and planned and not same_number(present, planned):
            raise PlanRefusedError(
                f"The session was planned for the robot {planned}; the cell file names {present} now. Its "
                "readings would be filed under the wrong robot: plan a new session."
            )

    def bound(self, stored: Cell) -> Cell:
        """Return a session's cell with the limits that bind its motions now; raises PlanRefusedError."""
        present = self._cell
        if present is None:
            return stored
        if present.robot.name != stored.robot.name:
            raise PlanRefusedError(
                f"The session was planned for the robot {stored.robot.name}; the cell has "
                f"{present.robot.name} now. Plan a new session for it."
            )
        if (present.simulated is None) != (stored.simulated is None):
            planned, found = ("a real", "simulated") if stored.simulated is None else ("a simulated", "real")
            raise PlanRefusedError(
                f"The session was planned in {planned} cell, and this one is {found}. What is simulated and "
                "what is measured are never mixed in one session: plan a new one."
            )
        speed = slowest(speed_limits(stored.limits), speed_limits(present.limits))
        limits = replace(
            stored.limits,
            joints=common_ranges(_joint_limits(stored), _joint_limits(present)),
            tool_speed_mm_s=speed.tool_speed_mm_s,
            orientation_speed_rad_s=speed.orientation_speed_rad_s,
            floor_z_mm=_higher(stored.limits.floor_z_mm, present.limits.floor_z_mm),
            keep_outs=stored.limits.keep_outs.joined(present.limits.keep_outs),
        )
        return replace(stored, limits=limits)


def speed_limits(limits: CellLimits) -> MotionLimits:
    """Return the speeds above which nothing moves in a cell."""
    return MotionLimits(limits.tool_speed_mm_s, limits.orientation_speed_rad_s)


def _higher(first_mm: float | None, second_mm: float | None) -> float | None:
    stated = [height for height in (first_mm, second_mm) if height is not None]
    return max(stated, default=None)


def _joint_limits(cell: Cell) -> tuple[JointRange, ...] | None:
    return cell.limits.joints or cell.robot.joint_limits
