"""The ACME G1 length gauge: a line of ASCII each way over TCP. Invented; a real driver names its manual.

`WHO` is answered `ACME model serial firmware`, `READ` `SHOWS count unit value state`, both of fixed width.
"""

import math
import re

from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.line_gauges.protocol import TextLines
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, introduction
from truepose_drivers.transports.tcp import tcp_link


class AcmeGauge:
    """A gauge on a link."""

    def __init__(self, link: Link, clock: Clock) -> None:
        self._conversation = Conversation(link, lambda: TextLines(str))
        self._clock = clock
        self._count = -1  # of the last reading of this connection

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._conversation.is_open

    async def connect(self) -> None:
        """Open the link and ask who is there; raises ConnectFailedError."""
        self._count = -1
        await self._conversation.open()
        async with introduction(self._conversation):
            await self.identify()

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._conversation.close()

    async def identify(self) -> DeviceIdentity:
        """Ask who it is."""
        return DeviceIdentity("ACME", *(await self._ask("WHO", r"ACME (\S+) (\S+) (\S+)")))

    async def read(self) -> BallbarReading:
        """Return what it shows now; raises RemoteProtocolError for another unit, or a count that stands."""
        count, value, state = await self._ask("READ", r"SHOWS (\d{6}) mm ([+-]\d\.\d{4}) (OK|NONE)")
        if int(count) <= self._count:
            await self.close()
            raise RemoteProtocolError(f"the gauge repeats reading {count}: switch it off and on again")
        self._count = int(count)
        time_s = await self._clock.now_s()
        if state == "NONE":
            return BallbarReading(math.nan, "none", 1e-4, time_s, sequence=self._count)
        return BallbarReading(float(value), "good", 1e-4, time_s, sequence=self._count)

    async def _ask(self, word: str, form: str) -> tuple[str, ...]:
        def decode(line: str) -> tuple[str, ...]:
            if (found := re.fullmatch(form, line)) is None:
                raise RemoteProtocolError(f"the gauge answers {line!r}: does it show millimetres?")
            return found.groups()

        silence = f"the gauge at {self._conversation.address} does not respond: check its cable and power"
        return await self._conversation.ask(f"{word}\n".encode(), decode, timeout_s=1.0, silence=silence)


def _open(options: Options, clock: Clock) -> AcmeGauge:
    return AcmeGauge(tcp_link(options, 9001), clock)


_OPTIONS = {"host": "address of the gauge", "port": "TCP port, 9001 unless changed"}
PLUGIN = DriverPlugin("acme_gauge", "ballbar", "acme", _OPTIONS, _open)
