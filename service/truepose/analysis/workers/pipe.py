"""Messages between the service and its worker: a length, then a pickle.

Pickle serves because both ends are this program, started by itself, on one pipe that nobody else holds.
"""

import pickle
import struct
from dataclasses import dataclass
from typing import Any, BinaryIO

_LENGTH = struct.Struct(">Q")
LENGTH_BYTES = _LENGTH.size


@dataclass(frozen=True, slots=True)
class Progressed:
    """The worker is so far: fraction from 0 to 1."""

    fraction: float
    doing: str


@dataclass(frozen=True, slots=True)
class Finished:
    """The worker's answer."""

    answer: Any


@dataclass(frozen=True, slots=True)
class Refused:
    """The task cannot be done, and the sentence that says why."""

    sentence: str
    code: str = ""  # of the error, where it has one


def packed(message: object) -> bytes:
    """Return a message as it travels."""
    body = pickle.dumps(message)
    return _LENGTH.pack(len(body)) + body


def body_length(head: bytes) -> int:
    """Return how many bytes follow a head of `LENGTH_BYTES`."""
    return int(_LENGTH.unpack(head)[0])


def unpacked(body: bytes) -> Any:
    """Return the message that `body` holds."""
    return pickle.loads(body)


def receive(stream: BinaryIO) -> Any:
    """Read one message; raises EOFError where the other end is gone."""
    head = stream.read(LENGTH_BYTES)
    if len(head) < LENGTH_BYTES:
        raise EOFError("the other end closed the pipe")
    return unpacked(stream.read(body_length(head)))
