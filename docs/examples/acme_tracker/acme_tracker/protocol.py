"""Wire protocol of the ACME tracker: one line of ASCII each way. No I/O here.

Source: invented for this example; a real driver names manual, revision and section. Lengths are in mm.
"""

import math
from dataclasses import dataclass

from truepose_drivers.errors import DeviceRefusedError, RemoteProtocolError

LONGEST_LINE_BYTES = 1000  # more without an end of line is no answer of this instrument


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer's first word and the words after it."""

    word: str
    rest: tuple[str, ...]

    def numbers(self, count: int) -> tuple[float, ...]:
        """Return exactly `count` finite numbers; raises RemoteProtocolError."""
        try:
            values = tuple(float(text) for text in self.rest)
        except ValueError as error:
            raise RemoteProtocolError(f"the tracker sent {self.rest} where numbers belong") from error
        if len(values) != count or not all(map(math.isfinite, values)):
            raise RemoteProtocolError(f"the tracker sent {self.rest}; {count} finite numbers belong there")
        return values


def encode(word: str, *values: float) -> bytes:
    """Return a request line."""
    return " ".join([word, *(f"{value:.4f}" for value in values)]).encode("ascii") + b"\n"


def decode(line: bytes) -> Reply:
    """Return the answer of a line; raises DeviceRefusedError, RemoteProtocolError."""
    words = line.decode("ascii", errors="replace").split()
    if not words:
        raise RemoteProtocolError("the tracker sent an empty line")
    if words[0] == "REFUSED":
        raise DeviceRefusedError(f"the tracker refused: {' '.join(words[1:]) or 'without a reason'}")
    return Reply(words[0], tuple(words[1:]))


class LineReader:
    """Reassembles lines from a byte stream."""

    def __init__(self) -> None:
        self._buffer = b""

    def receive_data(self, data: bytes) -> None:
        """Take what arrived; raises RemoteProtocolError where no line can come of it."""
        self._buffer += data
        if b"\n" not in self._buffer and len(self._buffer) > LONGEST_LINE_BYTES:
            raise RemoteProtocolError("the tracker sends no end of line")

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        return bool(self._buffer)

    def next_message(self) -> bytes | None:
        """Return the oldest complete line, None where there is none yet."""
        line, end, rest = self._buffer.partition(b"\n")
        if not end:
            return None
        self._buffer = rest
        return line
