"""Wire protocol of the simulated hands: one JSON object a line, UTF-8, one answer to each request.

``{"op": "do", "action": "connect", "base": 2, "tool": 3}`` is answered ``{"ok": true}``, or
``{"error": "..."}`` with a sentence. ``{"op": "who"}`` is answered ``{"ok": true, "who": "..."}``. The
details of an action are further keys; which there are is for the cell to say.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from truepose_drivers.framing import JsonLineError, Refusal, decode_object, encode_object, encode_refusal

Detail: TypeAlias = str | int | float | bool
_LARGEST = 2**53  # whole numbers beyond it are not the same to every reader of JSON
_OF_THE_REQUEST = frozenset({"op", "action"})


class HandsProtocolError(JsonLineError):
    """A line that is no request and no answer of the hands."""


@dataclass(frozen=True, slots=True)
class Who:
    """Request: who is there."""


@dataclass(frozen=True, slots=True)
class Do:
    """Request: do one thing."""

    action: str
    details: Mapping[str, Detail] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Done:
    """Answer: it is done; `who` answers a question."""

    who: str | None = None


Request: TypeAlias = Who | Do
Answer: TypeAlias = Done | Refusal


def encode(message: Request | Answer) -> bytes:
    """Return the line of a message; raises ValueError for a detail that cannot be sent."""
    match message:
        case Who():
            return encode_object({"op": "who"})
        case Do(action, details):
            if reserved := _OF_THE_REQUEST & details.keys():
                raise ValueError(f"a detail cannot be called {', '.join(sorted(reserved))}")
            return encode_object({"op": "do", "action": action, **details})
        case Done(who):
            return encode_object({"ok": True} if who is None else {"ok": True, "who": who})
        case Refusal():
            return encode_refusal(message)


def decode_request(line: bytes) -> Request:
    """Read a request; raises JsonLineError with a sentence for its sender."""
    match decode_object(line):
        case {"op": "who"}:
            return Who()
        case {"op": "do", "action": str(action), **details}:
            return Do(action, {key: _detail(key, value) for key, value in details.items()})
        case _:
            raise HandsProtocolError('a request is {"op": "do", "action": "connect", ...} or {"op": "who"}')


def decode_answer(line: bytes) -> Answer:
    """Read an answer; raises JsonLineError."""
    match decode_object(line):
        case {"error": str(sentence)}:
            return Refusal(sentence)
        case {"ok": True, "who": str(who)}:
            return Done(who)
        case {"ok": True}:
            return Done()
        case other:
            raise HandsProtocolError(f"the hands answered {other!r}; ok or error was expected")


def _detail(key: str, value: object) -> Detail:
    if isinstance(value, str | bool):
        return value
    if isinstance(value, int | float) and -_LARGEST <= value <= _LARGEST:  # NaN is not
        return value
    raise HandsProtocolError(f'key "{key}" is {value!r}; a text, a number or true or false was expected')
