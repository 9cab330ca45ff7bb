"""Frames of the variable proxy (KUKAVARPROXY, C3 Bridge): one variable read or written, big endian.

Source: the public server's own program. An answer bears the number of its request; its last byte says whether
the variable was read or written. A variable that is not there is read as nothing.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.stream_reader import StreamReader

PROXY_PORT: Final = 7000
NUMBERS: Final = 2**16  # of requests, which begin anew then
_HEAD: Final = struct.Struct(">HHB")  # number, size of what follows it, mode
_SIZE: Final = struct.Struct(">H")
_AFTER_SIZE: Final = 1  # bytes of the head that the size counts: the mode
_TAILS: Final = {b"\x00\x01\x01": True, b"\x00\x01\x00": False, b"\x00\x00\x00": False}
_TAIL_BYTES: Final = 3
_LONGEST: Final = 2_048  # of a request, as the public server reads it; answers are shorter


class ProxyProtocolError(RemoteProtocolError):
    """The other side sent bytes that are no frame of the variable proxy."""


class Mode(IntEnum):
    """What is done with a variable."""

    READ = 0
    WRITE = 1


@dataclass(frozen=True, slots=True)
class Request:
    """A variable to be read, or written where there is a value."""

    number: int
    name: str
    value: str | None = None

    @property
    def mode(self) -> Mode:
        """What is to be done."""
        return Mode.READ if self.value is None else Mode.WRITE


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of a request."""

    number: int
    mode: Mode
    value: str
    done: bool


class FrameReader(StreamReader):
    """Reassembles frames from a byte stream."""

    def _next_frame(self) -> tuple[int, Mode, bytes] | None:
        """Take the oldest whole frame: number, mode, and what follows; raises ProxyProtocolError."""
        if len(self._buffer) < _HEAD.size:
            return None
        number, size, mode = _HEAD.unpack_from(self._buffer)
        if not _AFTER_SIZE <= size <= _LONGEST or mode not in Mode.__members__.values():
            raise ProxyProtocolError(f"{bytes(self._buffer[:12])!r} begins no frame of the variable proxy")
        end = _HEAD.size - _AFTER_SIZE + size
        if len(self._buffer) < end:
            return None
        return number, Mode(mode), self._take(end)[_HEAD.size :]


class AnswerReader(FrameReader):
    """Reassembles what the proxy sends."""

    def next_message(self) -> Answer | None:
        """Take the oldest whole answer, None until more arrives; raises ProxyProtocolError."""
        frame = self._next_frame()
        if frame is None:
            return None
        number, mode, content = frame
        tail = content[-_TAIL_BYTES:]
        if tail not in _TAILS:
            raise ProxyProtocolError(f"{content!r} does not say whether it was done")
        value, rest = _block(content[:-_TAIL_BYTES])
        _require_end(rest)
        return Answer(number, mode, value, _TAILS[tail])


class RequestReader(FrameReader):
    """Reassembles what a client sends."""

    def next_message(self) -> Request | None:
        """Take the oldest whole request, None until more arrives; raises ProxyProtocolError."""
        frame = self._next_frame()
        if frame is None:
            return None
        number, mode, content = frame
        name, rest = _block(content)
        value = None
        if mode is Mode.WRITE:
            value, rest = _block(rest)
        _require_end(rest)
        return Request(number, name, value)


def encode_request(request: Request) -> bytes:
    """Return the frame of a request; raises ValueError where it is none."""
    blocks = [request.name] if request.value is None else [request.name, request.value]
    return _encode(request.number, request.mode, b"".join(map(_encoded, blocks)))


def encode_answer(answer: Answer) -> bytes:
    """Return the frame of an answer."""
    tail = b"\x00\x01" + bytes([answer.done])
    return _encode(answer.number, answer.mode, _encoded(answer.value) + tail)


def _encode(number: int, mode: Mode, content: bytes) -> bytes:
    size = _AFTER_SIZE + len(content)
    if size > _LONGEST:
        raise ValueError(f"a frame of {size} bytes is longer than the proxy reads")
    return _HEAD.pack(number, size, mode) + content


def _encoded(text: str) -> bytes:
    data = text.encode("ascii")
    return _SIZE.pack(len(data)) + data


def _block(content: bytes) -> tuple[str, bytes]:
    """Return the text at the beginning, and what follows it."""
    if len(content) < _SIZE.size:
        raise ProxyProtocolError(f"{content!r} ends before its text")
    (size,) = _SIZE.unpack_from(content)
    text, rest = content[_SIZE.size : _SIZE.size + size], content[_SIZE.size + size :]
    if len(text) < size or not text.isascii():
        raise ProxyProtocolError(f"{content[:40]!r} is no text of {size} characters")
    return text.decode("ascii"), rest


def _require_end(rest: bytes) -> None:
    if rest:
        raise ProxyProtocolError(f"{rest[:40]!r} stands behind the end of a frame")
