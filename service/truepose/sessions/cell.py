"""The cell as it is now, against what was stored with a session: what binds a motion is the tighter of both.

A session keeps the cell it was planned in, because its readings belong to that. What the arm may do is
another matter: whoever tightens a limit in the cell file means every motion from then on.
"""

import asyncio
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final, TypeAlias

from truepose.domain.cell import Cell, CellLimits
from truepose.domain.errors import TrueposeError, text_of
from truepose.domain.robot import JointRange
from truepose.messages.message import Message, message
from truepose.sessions.engine.identity_check import same_number
from truepose.sessions.engine.interlocks import common_ranges, slowest
from truepose.sessions.engine.prompts import require_announced
from truepose.sessions.errors import CellChangedError, PlanRefusedError
from truepose_drivers.api import MotionLimits

ReadCell: TypeAlias = Callable[[], Cell]


class CurrentCell:
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
            # The parsed cells are compared, the robot's file included: a comment in the file stops nobody
            # (decision 0019).
            found = await asyncio.to_thread(self._read_again)
        except TrueposeError as error:
            raise CellChangedError(message("session.cell_file.unreadable", why=text_of(error))) from error
        if found != self._cell:
            raise CellChangedError(message("session.cell_file.changed"))

    def require_person(self, person: str) -> str:
        """Return the name of somebody who may have the arm move.

        Raises PersonMissingError, PersonUnknownError.
        """
        return require_announced(person, self.people)

    def require_same_robot(self, stored: Cell) -> None:
        """Raise PlanRefusedError where a session was planned for a robot of another serial number."""
        present = "" if self._cell is None else self._cell.robot_serial_number
        planned = stored.robot_serial_number
        # Where one of the two names no number there is nothing to compare; the controller is asked for its
        # own before it moves.
        if present and planned and not same_number(present, planned):
            raise PlanRefusedError(message("session.planned_for.serial", planned=planned, present=present))

    def bound(self, stored: Cell) -> Cell:
        """Return a session's cell with the limits that bind its motions now; raises PlanRefusedError."""
        present = self._cell
        if present is None:
            return stored
        # Another type of robot has other limits and another nominal model: nothing that was planned holds for
        # it.
        if present.robot.name != stored.robot.name:
            raise PlanRefusedError(
                message("session.planned_for.type", planned=stored.robot.name, present=present.robot.name)
            )
        # What was rehearsed in a simulated cell must not go on in a real one because the cell file was
        # exchanged (commit 2004b8d6).
        if (present.simulated is None) != (stored.simulated is None):
            planned_in_real = stored.simulated is None
            raise PlanRefusedError(
                message("session.planned_in.real" if planned_in_real else "session.planned_in.simulated")
            )
        speed = slowest(speed_limits(stored.limits), speed_limits(present.limits))
        # Only the limits are taken from today. Everything else stays as it was planned: the readings belong
        # to that.
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


_DIFFERS: Final = {  # part of a cell: key of what is said where it is stated otherwise
    "robot": "again.differs.robot",
    "robot_serial_number": "again.differs.robot_serial",
    "base_nominal": "again.differs.base",
    "nests": "again.differs.nests",
    "tool": "again.differs.tool",
    "fixed_nests": "again.differs.fixed_nests",
    "world": "again.differs.world",
    "tracker_position_mm": "again.differs.tracker",
    "camera": "again.differs.camera",
    "ballbar": "again.differs.ballbar",
    "devices": "again.differs.devices",
    "limits": "again.differs.limits",
    "conditions": "again.differs.conditions",
    "simulated": "again.differs.simulated",
}


def differences(then: Cell, now: Cell) -> Iterator[Message]:
    """Yield a sentence for each part of the cell that is stated otherwise today; nothing where none is."""
    for part, key in _DIFFERS.items():
        if getattr(then, part) != getattr(now, part):
            yield message(key)
