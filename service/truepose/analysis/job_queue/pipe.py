"""Messages between the service and its worker: a length, then a pickle.

Pickle serves because both ends are this program, started by itself, on one pipe that nobody else holds.
"""

import os
import pickle
import struct
from dataclasses import dataclass
from typing import IO, Any, BinaryIO

from truepose.messages.message import Text

_LENGTH = struct.Struct(">Q")
LENGTH_BYTES = _LENGTH.size


@dataclass(frozen=True, slots=True)
class TaskProgress:
    """The worker is so far: fraction from 0 to 1."""

    fraction: float
    doing: Text


@dataclass(frozen=True, slots=True)
class TaskAnswer:
    """The worker's answer."""

    answer: Any


@dataclass(frozen=True, slots=True)
class TaskRefusal:
    """The task cannot be done, and the sentence that says why."""

    sentence: Text
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


def receive(stream: IO[bytes]) -> Any:
    """Read one message; raises EOFError where the other end is gone."""
    return unpacked(received(stream))


def received(stream: IO[bytes]) -> bytes:
    """Read the body of one message; raises EOFError where the other end is gone."""
    return _read(stream, body_length(_read(stream, LENGTH_BYTES)))


def _read(stream: IO[bytes], size: int) -> bytes:
    data = bytearray()
    while len(data) < size:  # a stream without a buffer gives what is there
        some = stream.read(size - len(data))
        if not some:
            raise EOFError("the other end closed the pipe")
        data += some
    return bytes(data)


def claimed_output() -> BinaryIO:
    """Return standard output, kept for messages; whatever a library prints goes to standard error."""
    # A library that prints would put its words between two messages, and no message after them could be read.
    pipe = os.dup(1)
    os.dup2(2, 1)
    return os.fdopen(pipe, "wb")
