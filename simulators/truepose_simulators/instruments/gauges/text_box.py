"""An endpoint of a box that answers lines of text, with what bad lines make of its answers."""

import asyncio
from collections.abc import Callable, Sequence
from typing import Final

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.line_gauges.text_lines import TextLines
from truepose_simulators.faults.wire import BallbarInches, BallbarKeyPressed, LineDoublesDigits, LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import with_doubled_digit, write_with_stall
from truepose_simulators.instruments.ballbars.length_source import Electronics, Shown
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES: Final = 4096
_MM_PER_INCH: Final = 25.4


class TextBox:
    """A box with its gauges; `answer` returns what it says to one line."""

    def __init__(self, gauges: Sequence[Electronics], answer: Callable[[str], bytes]) -> None:
        self._gauges = gauges
        self._answer = answer
        self._pressed = False  # a key, before the last question

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it goes."""
        lines: TextLines[str] = TextLines(str)
        while data := await reader.read(_CHUNK_BYTES):
            if not self._gauges[0].plugged:
                lines = TextLines(str)
                continue
            lines.receive_data(data)
            for said in _answers(lines, self._say):
                await self._write(writer, said)
            await writer.drain()

    def _say(self, line: str) -> bytes:
        said = self._answer(line)
        if self._gauges[0].has(LineDoublesDigits):
            said = with_doubled_digit(said)
        self._pressed = self._gauges[0].has(BallbarKeyPressed) and not self._pressed
        return said + said if self._pressed else said

    async def _write(self, writer: asyncio.StreamWriter, said: bytes) -> None:
        if self._gauges[0].has(LineStalls):
            await write_with_stall(writer, said)
        else:
            writer.write(said)


def _answers(lines: TextLines[str], say: Callable[[str], bytes]) -> Sequence[bytes]:
    said = []
    try:
        while (line := lines.next_message()) is not None:
            said.append(say(line))
    except RemoteProtocolError:  # nothing that a box could understand
        pass
    return said


def in_inches(gauge: Electronics, shown: Shown) -> tuple[float, bool]:
    """Return what a display shows, and whether it is in inches."""
    inches = gauge.has(BallbarInches)
    return shown.deviation_mm / (_MM_PER_INCH if inches else 1.0), inches


def box_endpoint(device: str, protocol: str, box: TextBox) -> Endpoint:
    """Build the endpoint of a box; every connection reaches the same one."""
    return Endpoint(device, protocol, box.serve)
