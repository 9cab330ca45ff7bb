"""What a cell is today that it was not when a session was planned: said before its plan is used again."""

from collections.abc import Iterator
from typing import Final

from truepose.domain.cell.description import Cell
from truepose.domain.sentences import Sentence, said

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


def differences(then: Cell, now: Cell) -> Iterator[Sentence]:
    """Yield a sentence for each part of the cell that is stated otherwise today; nothing where none is."""
    for part, key in _DIFFERS.items():
        if getattr(then, part) != getattr(now, part):
            yield said(key)
