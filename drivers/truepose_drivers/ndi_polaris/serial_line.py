"""A camera on a serial line: a break starts it again at 9600 baud, COMM takes it to 115200.

At which speed an earlier program left it nobody knows; a break is understood at any. Source: NDI's API guide,
as `ndicapi` speaks it (COMM, serial break, RESET).
"""

import asyncio
from typing import Final, Protocol

from truepose_drivers.errors import ConnectFailedError, LinkError
from truepose_drivers.ndi_polaris.protocol import OKAY, RESET, Reply, Request, encode_reply, encode_request
from truepose_drivers.transports.link import Link, OverPort

FIRST_BAUD: Final = 9600
_FAST_BAUD: Final = 115_200
_FASTER: Final = Request("COMM", "50000")  # 115200 baud, 8 bits, no parity, 1 stop bit, no handshake
_STARTED_WITHIN_S: Final = 10.0
_AGREED_WITHIN_S: Final = 2.0
_SWITCHED_S: Final = 0.1  # after its answer the camera takes so long to change its speed
_MOST_NOISE: Final = 4096  # bytes before an answer: half a line of frames at the wrong speed is less


class Line(Link, Protocol):
    """A serial port that can do what a camera's needs."""

    async def send_break(self) -> None:
        """Hold the line low."""
        ...

    async def set_baud(self, baud: int) -> None:
        """Go on at another speed."""
        ...


class CameraLine(OverPort):
    """The link of a driver to a camera behind a serial port."""

    def __init__(self, line: Line) -> None:
        super().__init__(line)
        self._line = line

    async def open(self) -> None:
        """Start the camera again and agree on a speed; raises ConnectFailedError."""
        await self._line.open()
        try:
            await self._line.send_break()
            await self._heard(RESET, _STARTED_WITHIN_S, "did not start again")
            await self._line.send(encode_request(_FASTER))
            await self._heard(OKAY, _AGREED_WITHIN_S, "did not agree to 115200 baud")
            # The camera agrees at the old speed and changes afterwards.
            await asyncio.sleep(_SWITCHED_S)
            await self._line.set_baud(_FAST_BAUD)
        except LinkError as error:
            await self._line.close()
            raise ConnectFailedError(str(error)) from error
        except BaseException:
            await self._line.close()
            raise

    async def send(self, data: bytes) -> None:
        """Hand `data` to the port; raises ConnectionLostError."""
        await self._line.send(data)

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        return await self._line.receive(timeout_s)

    async def _heard(self, reply: Reply, within_s: float, instead: str) -> None:
        """Wait for a reply among what else is on the line; raises ConnectFailedError."""
        wanted, arrived = encode_reply(reply), b""
        while wanted not in arrived:
            data = await self._line.receive(within_s)
            arrived += data or b""
            if data is None or len(arrived) > _MOST_NOISE:
                raise ConnectFailedError(
                    f"the camera at {self.address} {instead}: check that it is switched on, its cable, and"
                    " that this is its port"
                )
