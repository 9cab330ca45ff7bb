"""What may be done to a simulated cell by hand: its faults, and the hands of the person at it."""

import math
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final, TypeAlias

from truepose.domain.robot import FramePlacement
from truepose.messages.message import message
from truepose.sessions.cell import CurrentCell
from truepose.sessions.devices import DeviceRegistry
from truepose.sessions.errors import FaultRefusedError, RealCellError
from truepose_drivers.api import Options

AskCell: TypeAlias = Callable[[Mapping[str, object]], Awaitable[dict[str, Any]]]


class FaultService:
    """Passes on what is to go wrong, and remembers who wanted it; `ask` is None where the cell is real."""

    def __init__(self, ask: AskCell | None, present: CurrentCell) -> None:
        self._ask = ask
        self._present = present
        self._given_by: dict[int, str] = {}

    @property
    def simulated(self) -> bool:
        """Whether the cell has faults on order."""
        return self._ask is not None

    async def kinds(self) -> list[dict[str, Any]]:
        """Return what may go wrong, with the keys of each; raises RealCellError."""
        found: list[dict[str, Any]] = (await self._answer({"op": "kinds"}))["kinds"]
        return found

    async def given(self) -> dict[str, Any]:
        """Return the cell's time and every fault so far, with who gave it; raises RealCellError."""
        answer = await self._answer({"op": "list"})
        for fault in answer["faults"]:
            fault["person"] = self._given_by.get(fault["number"])
        return answer

    async def give(self, person: str, kind: str, keys: Mapping[str, object]) -> int:
        """Have something go wrong and return its number.

        Raises RealCellError, FaultRefusedError with the cell's own sentence, PersonMissingError,
        PersonUnknownError.
        """
        # As for every act: whoever makes something go wrong in a session is asked who they are.
        name = self._present.require_person(person)
        number = int((await self._answer({**keys, "op": "give", "kind": kind}))["number"])
        self._given_by[number] = name
        return number

    async def end(self, person: str, number: int) -> None:
        """End a fault; raises as `give`."""
        self._present.require_person(person)
        await self._answer({"op": "end", "number": number})

    async def _answer(self, request: Mapping[str, object]) -> dict[str, Any]:
        if self._ask is None:
            raise RealCellError(message("session.refused.faults_of_real"))
        answer = await self._ask(request)
        if "error" in answer:
            raise FaultRefusedError(message("session.refused.fault", why=answer["error"]))
        return answer


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


class SimulatedOperatorService:
    """Passes on what the hands are to do, and remembers where they put the ballbar."""

    def __init__(self, rack: DeviceRegistry, place_of: Callable[[int], FramePlacement | None]) -> None:
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
            raise RealCellError(message("session.refused.hands_of_real"))
        if not hands.connected:
            await hands.connect()
        await hands.do(action, self._placed(details) if action == "place_base" else details)
        # Only after the cell has done it.
        if action in _TAKES | _LEAVES:
            self.holding = "" if action in _LEAVES else _words(action, details)

    def _placed(self, details: Options) -> Options:
        """Return the details with the mark on the table where nobody says another."""
        frame = self._place_of(int(details.get("placement", 1)))
        # Whoever states a place has put the fixture elsewhere on purpose.
        if frame is None or "x_mm" in details:
            return details
        turns = {f"r{axis}_deg": math.degrees(getattr(frame, f"r{axis}_rad")) for axis in "xyz"}
        return {**details, "x_mm": frame.x_mm, "y_mm": frame.y_mm, "z_mm": frame.z_mm, **turns}


def _words(action: str, details: Options) -> str:
    return " ".join([action, *(f"{key} {value}" for key, value in details.items())])
