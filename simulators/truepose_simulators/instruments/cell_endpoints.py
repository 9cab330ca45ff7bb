"""Endpoints of the cell itself, as JSON lines: its clock, its operator, and the faults that it is given.

- `{"op": "kinds"}` gives `{"kinds": [{"kind": ..., "keys": [{"key", "type", "required"}]}]}`;
- `{"op": "list"}` gives `{"now_s": ..., "faults": [...]}`: every fault that was given, and what became of it;
- `{"op": "give", "kind": ..., ...}` gives `{"number": 3}`: a `[[fault]]` of a file (docs/faults.md);
- `{"op": "end", "number": 3}` ends one.
"""

import asyncio
import dataclasses
import inspect
import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final, Protocol, TypeAlias, get_type_hints

from truepose_drivers.cell_clock import protocol as clock_protocol
from truepose_drivers.cell_hands import protocol as hands_protocol
from truepose_drivers.framing import JsonLineError, Refusal
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import SimulatorError, TruthRequestError
from truepose_simulators.faults.file import read_fault
from truepose_simulators.faults.kinds import KINDS
from truepose_simulators.faults.times import Fault, Lasting, ScheduledFault
from truepose_simulators.instruments.endpoint import Endpoint, line_endpoint
from truepose_simulators.physics.arm import Vector

Operation: TypeAlias = Callable[[Mapping[str, object], Cell], dict[str, Any]]
Operations: TypeAlias = Mapping[str, Operation]


def requests_endpoint(
    name: str, answer: Callable[[bytes], dict[str, Any]], *, longest_bytes: int
) -> Endpoint:
    """Build an endpoint that answers each line."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while True:
            try:
                line = await reader.readline()
            except ValueError:  # the reader's word for a line that does not end
                writer.write(_encode({"error": f"a request is one line of at most {longest_bytes} bytes"}))
                return
            if not line:
                return
            writer.write(_encode(answer(line)))
            await writer.drain()

    return Endpoint(name, name, serve, buffer_bytes=longest_bytes)


def carry_out(line: bytes, operations: Operations, cell: Cell) -> dict[str, Any]:
    """Carry out one request line; an impossible one is answered with an error."""
    try:
        request = _decode(line)
        operation = request.get("op")
        if not isinstance(operation, str) or operation not in operations:
            raise TruthRequestError(f'key "op" must be one of {", ".join(operations)}')
        rest = {key: value for key, value in request.items() if key != "op"}
        return operations[operation](rest, cell)
    except SimulatorError as error:
        return {"error": str(error)}


def _encode(document: dict[str, Any]) -> bytes:
    return json.dumps(document, allow_nan=False).encode() + b"\n"


def _decode(line: bytes) -> dict[str, Any]:
    try:
        request = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise TruthRequestError(f"the request is not JSON: {error}") from error
    if not isinstance(request, dict):
        raise TruthRequestError('a request is an object such as {"op": "plant"}')
    return request


def clock_endpoint(clock: CellClock) -> Endpoint:
    """Build the endpoint of a clock."""

    async def reply(line: bytes) -> bytes:
        return clock_protocol.encode(await answer_clock(line, clock))

    return line_endpoint("clock", reply)


async def answer_clock(line: bytes, clock: CellClock) -> clock_protocol.Answer:
    """Carry out one request line."""
    try:
        request = clock_protocol.decode_request(line)
    except JsonLineError as error:
        return Refusal(str(error))
    if isinstance(request, clock_protocol.Sleep):
        await clock.sleep(request.duration_s)
    return clock_protocol.Time(clock.now_s)


_WHO = "simulated hands"


class Hands(Protocol):
    """What the person at the cell can be asked to do."""

    def do(self, action: str, details: Mapping[str, hands_protocol.Detail]) -> Awaitable[None] | None:
        """Do one thing, or raise SimulatorError with a sentence."""


def hands_endpoint(hands: Hands) -> Endpoint:
    """Build the endpoint of the hands; deeds asked for over several connections follow one another."""
    busy = asyncio.Lock()

    async def reply(line: bytes) -> bytes:
        async with busy:
            return hands_protocol.encode(await answer_hands(line, hands))

    return line_endpoint("hands", reply)


async def answer_hands(line: bytes, hands: Hands) -> hands_protocol.Answer:
    """Carry out one request line."""
    try:
        request = hands_protocol.decode_request(line)
        if isinstance(request, hands_protocol.Who):
            return hands_protocol.Done(_WHO)
        doing = hands.do(request.action, request.details)
        if inspect.isawaitable(doing):
            await doing
    except (JsonLineError, SimulatorError) as error:
        return Refusal(str(error))
    return hands_protocol.Done()


_LONGEST_LINE_BYTES: Final = 1 << 14
_WHEN: Final = {item.name for item in (*dataclasses.fields(Lasting), *dataclasses.fields(ScheduledFault))}
_TYPES: Final = {float: "number", int: "whole", int | None: "whole", str: "text", Vector: "vector"}


def faults_endpoint(cell: Cell) -> Endpoint:
    """Build the endpoint of the faults of a cell."""
    return requests_endpoint(
        "faults", lambda line: carry_out(line, _OPERATIONS, cell), longest_bytes=_LONGEST_LINE_BYTES
    )


def _kinds(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    del request, cell
    return {"kinds": [{"kind": name, "keys": _keys(kind)} for name, kind in KINDS.items()]}


def _keys(kind: type[Fault]) -> list[dict[str, object]]:
    hints = get_type_hints(kind)
    return [
        {
            "key": item.name,
            "type": _TYPES[hints[item.name]],
            "required": item.default is dataclasses.MISSING,
        }
        for item in sorted(dataclasses.fields(kind), key=lambda item: item.name in _WHEN)
    ]


def _list(_: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    now_s = cell.clock.now_s
    return {"now_s": now_s, "faults": [given.document(now_s) for given in cell.faults.given]}


def _give(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    return {"number": cell.add_fault(read_fault(request, "fault"))}


def _end(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    number = request.get("number")
    if type(number) is not int:
        raise TruthRequestError(f'key "number" must be a whole number, not {number!r}')
    cell.faults.end(number)
    return {}


_OPERATIONS: Final[Operations] = {"kinds": _kinds, "list": _list, "give": _give, "end": _end}
