"""What bad lines make of an answer."""

import asyncio
import re
from typing import Final, Protocol

_STALL_S: Final = 0.05  # wall time: a line knows no other
_FIRST_DIGIT: Final = re.compile(rb"([+-])(\d)")


class Writer(Protocol):
    """What is needed of a stream."""

    def write(self, data: bytes) -> None:
        """Hand over `data`."""
        ...

    async def drain(self) -> None:
        """Wait until it is gone."""
        ...


async def write_with_stall(writer: Writer, data: bytes) -> None:
    """Write `data` in two halves, with a stall between them."""
    half = len(data) // 2
    writer.write(data[:half])
    await writer.drain()
    await asyncio.sleep(_STALL_S)
    writer.write(data[half:])


def with_doubled_digit(data: bytes) -> bytes:
    """Return `data` with the first digit behind each sign twice."""
    return _FIRST_DIGIT.sub(rb"\1\2\2", data)
