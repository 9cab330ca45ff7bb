"""What an engineer at a simulated cell may do to it, as JSON lines; nothing of its truth is told here.

- `{"op": "kinds"}` gives `{"kinds": [{"kind": ..., "keys": [{"key", "type", "required"}]}]}`;
- `{"op": "list"}` gives `{"now_s": ..., "faults": [...]}`: every fault that was given, and what became of it;
- `{"op": "give", "kind": ..., ...}` gives `{"number": 3}`: a `[[fault]]` of a file (docs/faults.md);
- `{"op": "end", "number": 3}` ends one.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, Final, get_type_hints

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import TruthRequestError
from truepose_simulators.faults.kinds import KINDS
from truepose_simulators.faults.table import read_fault
from truepose_simulators.faults.times import Fault, Lasting, Striking
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.json_requests import Operations, carry_out, requests_endpoint
from truepose_simulators.physics.arm import Vector

_LONGEST_LINE_BYTES: Final = 1 << 14
_WHEN: Final = {item.name for item in (*dataclasses.fields(Lasting), *dataclasses.fields(Striking))}
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


def _list(request: Mapping[str, object], cell: Cell) -> dict[str, Any]:
    del request
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
