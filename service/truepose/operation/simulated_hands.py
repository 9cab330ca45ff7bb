"""The hands of the person at a simulated cell: what a demonstration has them do."""

import math
from collections.abc import Callable
from typing import Final

from truepose.domain.robot import FramePlacement
from truepose.operation.devices import Rack
from truepose.operation.errors import RealCellError
from truepose_drivers.api import Options

ACTIONS: Final = (
    "calibrator",
    "connect",
    "side",
    "detach",
    "place_base",
    "fit_ball",
    "remove_ball",
    "clamp",
    "pull_cable",
    "plug_cable",
    "hold",
    "switch_off",
    "switch_on",
)
_TAKES: Final = frozenset({"calibrator", "connect", "side"})
_LEAVES: Final = frozenset({"detach", "hold"})


class HandsDesk:
    """Passes on what the hands are to do, and remembers where they put the ballbar."""

    def __init__(self, rack: Rack, place_of: Callable[[int], FramePlacement | None]) -> None:
        self._rack = rack
        self._place_of = place_of  # where the session wants the base fixture
        self.holding = ""  # where the ballbar is, in words; empty: in the hand

    @property
    def simulated(self) -> bool:
        """Whether the cell has simulated hands."""
        return self._rack.hands is not None

    async def do(self, action: str, details: Options) -> None:
        """Do one thing; raises RealCellError, DeviceRefusedError with the sentence why it cannot be done."""
        hands = self._rack.hands
        if hands is None:
            raise RealCellError("No hands are simulated in this cell: a person stands there.")
        if not hands.connected:
            await hands.connect()
        await hands.do(action, self._placed(details) if action == "place_base" else details)
        if action in _TAKES | _LEAVES:
            self.holding = "" if action in _LEAVES else _words(action, details)

    def _placed(self, details: Options) -> Options:
        """Return the details with the mark on the table where nobody says another."""
        frame = self._place_of(int(details.get("placement", 1)))
        if frame is None or "x_mm" in details:
            return details
        turns = {f"r{axis}_deg": math.degrees(getattr(frame, f"r{axis}_rad")) for axis in "xyz"}
        return {**details, "x_mm": frame.x_mm, "y_mm": frame.y_mm, "z_mm": frame.z_mm, **turns}


def _words(action: str, details: Options) -> str:
    return " ".join([action, *(f"{key} {value}" for key, value in details.items())])
