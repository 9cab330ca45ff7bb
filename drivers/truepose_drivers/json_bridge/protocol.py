"""Lines of an instrument bridge: one JSON object a line, UTF-8; we ask, the bridge answers. See README.md.

A question is ``{"id": 7, "ask": "measure_point", "duration_s": 2.0}``. Its answer carries the same `id` and
the `serial` of the instrument; one with measured numbers also ``"unit": "mm"`` and a `sequence` that grows.
While a question takes longer the bridge says ``{"id": 7, "busy": true}``; what cannot be done is
``{"id": 7, "error": "beam_broken", "sentence": "..."}``. Keys not listed here are ignored.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, TypeAlias, get_args

from truepose_drivers.framing import JsonLineError, decode_object, encode_object, finite_number

VERSION = 1
UNIT = "mm"
Ask: TypeAlias = Literal[
    "hello", "initialise", "find_reflector", "measure_point", "measure_pose", "change_face", "environment"
]
_ASKS: tuple[Ask, ...] = get_args(Ask)
_HIGHEST = 2**63 - 1  # of what is counted
_LONGEST_TEXT = 300


class BridgeError(JsonLineError):
    """A line that is none of an instrument bridge."""


@dataclass(frozen=True, slots=True)
class Question:
    """What the bridge is to do, with its numbers."""

    number: int
    ask: Ask
    details: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, slots=True)
class Busy:
    """The bridge is still at a question."""

    number: int


@dataclass(frozen=True, slots=True)
class Failure:
    """The bridge could not do it: `kind` is one of a few words, the sentence is for people."""

    number: int
    kind: str
    sentence: str


@dataclass(frozen=True, slots=True)
class Answer:
    """What a question is answered with."""

    number: int
    serial: str
    values: Mapping[str, object]


Reply: TypeAlias = Busy | Failure | Answer


def encode_question(question: Question) -> bytes:
    """Return the line of a question."""
    return encode_object({"id": question.number, "ask": question.ask, **question.details})


def decode_question(line: bytes) -> Question:
    """Read a question; raises JsonLineError."""
    document = decode_object(line)
    ask = next((known for known in _ASKS if known == document.get("ask")), None)
    if ask is None:
        raise BridgeError(f"ask is {document.get('ask')!r}; expected one of {', '.join(_ASKS)}")
    details = {key: value for key, value in document.items() if key not in ("id", "ask")}
    return Question(_count(document, "id"), ask, MappingProxyType(details))


def encode_reply(reply: Reply) -> bytes:
    """Return the line of what the bridge says."""
    match reply:
        case Busy(number):
            return encode_object({"id": number, "busy": True})
        case Failure(number, kind, sentence):
            return encode_object({"id": number, "error": kind, "sentence": sentence})
        case Answer(number, serial, values):
            return encode_object({"id": number, "serial": serial, **values})


def decode_reply(line: bytes) -> Reply:
    """Read what the bridge says; raises JsonLineError with a sentence for whoever writes the bridge."""
    document = decode_object(line)
    number = _count(document, "id")
    if "error" in document:
        return Failure(number, text(document, "error"), text(document, "sentence"))
    if "busy" in document:
        if document["busy"] is not True:
            raise BridgeError(f"busy is {_shown(document['busy'])}; expected true")
        return Busy(number)
    values = {key: value for key, value in document.items() if key not in ("id", "serial")}
    return Answer(number, text(document, "serial"), MappingProxyType(values))


def measurement_number(answer: Answer) -> int:
    """Return the number of the measurement that an answer is of; raises BridgeError for another unit."""
    if answer.values.get("unit") != UNIT:
        raise BridgeError(
            f"unit is {_shown(answer.values.get('unit'))}: every answer with numbers says"
            f' "unit": "{UNIT}", and is in millimetres'
        )
    return newest_measurement(answer)


def newest_measurement(answer: Answer) -> int:
    """Return the number of the newest measurement; raises BridgeError."""
    return _count(answer.values, "sequence")


def number(values: Mapping[str, object], key: str) -> float:
    """Return a number; raises BridgeError."""
    found = finite_number(values.get(key))
    if found is None:
        raise BridgeError(f"{key} is {_shown(values.get(key))}; expected a number")
    return found


def numbers(values: Mapping[str, object], key: str, count: int) -> tuple[float, ...]:
    """Return so many numbers; raises BridgeError."""
    given = values.get(key)
    found = [finite_number(value) for value in given] if isinstance(given, list) else []
    whole = tuple(value for value in found if value is not None)
    if not len(whole) == len(found) == count:
        raise BridgeError(f"{key} is {_shown(given)}; expected {count} numbers")
    return whole


def text(values: Mapping[str, object], key: str) -> str:
    """Return a text that is not empty; raises BridgeError."""
    found = values.get(key)
    if not isinstance(found, str) or not found.strip():
        raise BridgeError(f"{key} is {_shown(found)}; expected a text")
    return found[:_LONGEST_TEXT]


def _count(values: Mapping[str, object], key: str) -> int:
    found = values.get(key)
    if isinstance(found, bool) or not isinstance(found, int) or not 0 <= found <= _HIGHEST:
        raise BridgeError(f"{key} is {_shown(found)}; expected a count")
    return found


def _shown(value: object) -> str:
    return "missing" if value is None else repr(value)[:40]
