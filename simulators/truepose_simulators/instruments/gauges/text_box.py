"""An endpoint of a box that answers lines of text, with what bad lines make of its answers."""

import asyncio
import re
from collections.abc import Callable, Sequence
from typing import Final

from truepose_simulators.faults.wire import BallbarInches, BallbarKeyPressed, LineDoublesDigits, LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import with_doubled_digit, write_with_stall
from truepose_simulators.instruments.ballbars.length_source import Electronics, Shown
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES: Final = 4096
_MM_PER_INCH: Final = 25.4
_LONGEST_QUESTION: Final = 100
_END: Final = re.compile(rb"[\r\n]")


class Questions:
    """Puts lines together; noise, and what no box could hold, is forgotten up to the next end of a line."""

    def __init__(self) -> None:
        self._begun = b""

    def receive(self, data: bytes) -> list[str]:
        """Return the lines that are whole now."""
        *whole, begun = _END.split(self._begun + data)
        self._begun = begun[: _LONGEST_QUESTION + 1]  # one too many: still too long when its end comes
        return [
            line.decode("ascii") for line in whole if line.isascii() and 0 < len(line) <= _LONGEST_QUESTION
        ]


class TextBox:
    """A box with its gauges; `answer` returns what it says to one line."""

    def __init__(self, gauges: Sequence[Electronics], answer: Callable[[str], bytes]) -> None:
        self._gauges = gauges
        self._answer = answer
        self._pressed = False  # a key, before the last question

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it goes."""
        questions = Questions()
        while data := await reader.read(_CHUNK_BYTES):
            if not self._gauges[0].plugged:
                questions = Questions()
                continue
            for said in map(self._say, questions.receive(data)):
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


def in_inches(gauge: Electronics, shown: Shown) -> tuple[float, bool]:
    """Return what a display shows, and whether it is in inches."""
    inches = gauge.has(BallbarInches)
    return shown.deviation_mm / (_MM_PER_INCH if inches else 1.0), inches


def box_endpoint(device: str, protocol: str, box: TextBox) -> Endpoint:
    """Build the endpoint of a box; every connection reaches the same one."""
    return Endpoint(device, protocol, box.serve)
