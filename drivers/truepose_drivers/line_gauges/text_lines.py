"""Lines of text from a serial box: ended by CR, LF or both, whatever its switches say."""

from collections.abc import Callable
from typing import Generic, TypeVar

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.stream_reader import StreamReader

Message = TypeVar("Message")

_ENDS = b"\r\n"
_LONGEST_LINE = 400  # of fifteen amplifiers with their output states


class LineGaugeError(RemoteProtocolError):
    """A gauge sent a line that its manual does not know."""


class TextLines(StreamReader, Generic[Message]):
    """Puts lines together and reads each of them with `decode`; serves both sides of the wire."""

    def __init__(self, decode: Callable[[str], Message]) -> None:
        super().__init__()
        self._decode = decode

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken; the second half of an end of line is nothing."""
        return bool(self._buffer.lstrip(_ENDS))

    def next_message(self) -> Message | None:
        """Take the oldest whole line, None until more arrives; raises RemoteProtocolError."""
        del self._buffer[: len(self._buffer) - len(self._buffer.lstrip(_ENDS))]
        end = min((at for at in map(self._buffer.find, (b"\r", b"\n")) if at >= 0), default=-1)
        if (end if end >= 0 else len(self._buffer)) > _LONGEST_LINE:
            raise LineGaugeError(
                f"{bytes(self._buffer[:20])!r}... does not end: check the rate, and what is on this line"
            )
        return None if end < 0 else self._decode(_ascii(self._take(end, drop=1)))


def _ascii(line: bytes) -> str:
    try:
        return line.decode("ascii")
    except UnicodeDecodeError as error:
        raise LineGaugeError(f"{line[:20]!r} is no text: check rate, data bits and parity") from error
