"""The dashboard: questions and answers of a line each, after a greeting. Source: maker's dashboard guide."""

import re
from typing import Final

from truepose_drivers.stream_reader import StreamReader
from truepose_drivers.universal_robots.protocol.errors import UrProtocolError

DASHBOARD_PORT: Final = 29999
GREETING: Final = "Connected: Universal Robots Dashboard Server"
SERIAL_NUMBER: Final = "get serial number"
ROBOT_MODEL: Final = "get robot model"

_LONGEST_LINE_BYTES = 1000
_NOT_UNDERSTOOD = "could not understand"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._/-]{0,39}")


class LineReader(StreamReader):
    """Reassembles lines; serves both sides of the wire."""

    def next_message(self) -> str | None:
        """Take the oldest whole line; raises UrProtocolError where one does not end."""
        end = self._buffer.find(b"\n")
        if max(end, len(self._buffer) if end < 0 else 0) > _LONGEST_LINE_BYTES:
            raise UrProtocolError(f"{bytes(self._buffer[:40])!r} goes on without the end of a line")
        if end < 0:
            return None
        return self._take(end, drop=1).decode(errors="replace").strip()


def encode_line(line: str) -> bytes:
    """Return a line as it goes over the wire."""
    return f"{line}\n".encode()


def require_greeting(line: str) -> None:
    """Raise UrProtocolError unless a dashboard speaks."""
    if not line.startswith(GREETING):
        raise UrProtocolError(f"whoever answers with {line[:60]!r} is no dashboard of Universal Robots")


def stated_name(line: str) -> str | None:
    """Return a serial number or model, None where this software does not know the question."""
    if _NOT_UNDERSTOOD in line.lower():
        return None
    if _NAME.fullmatch(line) is None:
        raise UrProtocolError(f"the dashboard answered with {line[:60]!r}, which is no name")
    return line
