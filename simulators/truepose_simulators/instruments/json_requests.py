"""Requests to a cell as JSON lines: an operation with its keys in, an answer or an error out."""

import asyncio
import json
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import SimulatorError, TruthRequestError
from truepose_simulators.instruments.endpoint import Endpoint

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
        raise TruthRequestError(f"the request is no JSON: {error}") from error
    if not isinstance(request, dict):
        raise TruthRequestError('a request is an object such as {"op": "plant"}')
    return request
