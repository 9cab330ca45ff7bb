"""Messages in a stream of bytes: those that wait until they are whole, and lines of JSON objects."""

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass

from truepose_drivers.errors import RemoteProtocolError


class StreamReader:
    """Collects what a stream delivers; a codec's reader takes its messages from there."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        return bool(self._buffer)

    def receive_data(self, data: bytes) -> None:
        """Append what the stream delivered."""
        self._buffer += data

    def _take(self, length: int, *, drop: int = 0) -> bytes:
        """Return the oldest `length` bytes, and drop those that only end them."""
        taken = bytes(self._buffer[:length])
        del self._buffer[: length + drop]
        return taken


LONGEST_LINE_BYTES = 1_024  # a message of any of these protocols is shorter than 300 bytes


class JsonLineError(RemoteProtocolError):
    """A line that is no message of the protocol spoken here."""


class LineReader(StreamReader):
    """Reassembles lines from a byte stream; serves both sides of the wire."""

    def next_message(self) -> bytes | None:
        """Take the oldest whole line without its end, None until more bytes arrive.

        Raises JsonLineError when a line does not end.
        """
        end = self._buffer.find(b"\n")
        # A peer that never ends its line is told from a slow one by length alone; without a bound, whatever
        # streams at a wrong port would fill the memory.
        if (end if end >= 0 else len(self._buffer)) > LONGEST_LINE_BYTES:
            raise JsonLineError(f"a line of more than {LONGEST_LINE_BYTES} bytes: is this the right port?")
        if end < 0:
            return None
        return self._take(end, drop=1)


@dataclass(frozen=True, slots=True)
class Refusal:
    """Answer of whoever cannot do what was asked: a sentence that says why."""

    sentence: str


def encode_refusal(refusal: Refusal) -> bytes:
    """Return the line of a refusal."""
    return encode_object({"error": refusal.sentence})


def encode_object(document: Mapping[str, object]) -> bytes:
    """Return the line of an object; raises ValueError when a number is not finite."""
    # Python would write NaN and Infinity, which are no JSON (RFC 8259, section 6).
    return json.dumps(document, allow_nan=False).encode() + b"\n"


def decode_object(line: bytes) -> dict[str, object]:
    """Read the object of a line; raises JsonLineError."""
    try:
        document = json.loads(line, object_pairs_hook=_each_key_once)
    # A line of opening brackets ends the parser by its depth, not by its form.
    except (ValueError, RecursionError) as error:
        raise JsonLineError(f"{line[:80]!r} is not JSON: {error}") from error
    if not isinstance(document, dict):
        raise JsonLineError(f"{line[:80]!r} is not a JSON object")
    return document


def _each_key_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Return an object; raises ValueError where a key comes twice, as in two lines that ran into one."""
    document = dict(pairs)
    if len(document) != len(pairs):
        raise ValueError("a key appears twice")
    return document


def finite_number(value: object) -> float | None:
    """Return a number of a document, None for one that is not finite or no number at all."""
    # In Python true is an int: a device that says true must not be read as 1 mm.
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    # Whole numbers of JSON have no end, and those beyond a double's range cannot even be asked.
    return float(value) if -sys.float_info.max <= value <= sys.float_info.max else None
