"""The faults of a simulated cell, given by hand: what an engineer may do to it, and what became of it."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, TypeAlias

from truepose.operation.errors import FaultRefusedError, RealCellError
from truepose.operation.present_cell import PresentCell

AskCell: TypeAlias = Callable[[Mapping[str, object]], Awaitable[dict[str, Any]]]


class FaultsDesk:
    """Passes on what is to go wrong, and remembers who wanted it; `ask` is None where the cell is real."""

    def __init__(self, ask: AskCell | None, present: PresentCell) -> None:
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
            raise RealCellError("Only a simulated cell has faults on order; this one is real.")
        answer = await self._ask(request)
        if "error" in answer:
            raise FaultRefusedError(f"The cell refuses that: {answer['error']}.")
        return answer
