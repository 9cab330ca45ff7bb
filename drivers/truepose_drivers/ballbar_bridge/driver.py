"""A ballbar behind a bridge: a program of the shop's that passes on what the maker's software reads."""

from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.ballbar_bridge.protocol import BridgeProtocolError, BridgeReading, Hello, decode
from truepose_drivers.framing import LineReader
from truepose_drivers.transports.conversation import Listener
from truepose_drivers.transports.link import Link, OnePortDevice, introduction
from truepose_drivers.transports.tcp import tcp_link

PORT = 7420  # ours, and free to choose: no registry lists it
# A bridge sends a value at least once a second (README.md): twice that is silence.
_VALUE_TIMEOUT_S = 2.0
_UNKNOWN = "unknown"


class BridgedBallbar(OnePortDevice):
    """A ballbar bridge on a link; it sends a line for each value, and we only listen."""

    def __init__(self, link: Link, clock: Clock, *, value_timeout_s: float = _VALUE_TIMEOUT_S) -> None:
        self._lines: Listener[bytes] = Listener(link, LineReader)
        super().__init__(self._lines)
        self._clock = clock
        self._value_timeout_s = value_timeout_s
        self._hello = Hello()
        self._last: int | None = None  # number of the newest value of this connection

    async def connect(self) -> None:
        """Open the link and wait for a first value; raises ConnectFailedError."""
        # Of this connection: a bridge that was started again counts from its own beginning.
        self._hello, self._last = Hello(), None
        await self._lines.open()
        async with introduction(self._lines), self._lines.turn():
            await self._next_value()

    async def identify(self) -> DeviceIdentity:
        """Return what the bridge said of the ballbar, once another value has shown that it is there."""
        async with self._lines.turn():
            await self._next_value()
        return DeviceIdentity(
            _UNKNOWN, self._hello.model or "bridged ballbar", self._hello.serial or _UNKNOWN, _UNKNOWN
        )

    async def read(self) -> BallbarReading:
        """Return the newest value of those that arrive after the ones that had arrived before."""
        async with self._lines.turn():
            await self._take_what_came()
            # The line whose end is still to come was begun before we asked.
            if self._lines.inside_message:
                await self._next_value()
            reading = await self._next_value()
            # Where the network stalled, the values of that time come at once, oldest first.
            reading = await self._take_what_came() or reading
        return BallbarReading(
            deviation_mm=reading.deviation_mm,
            signal=reading.signal,
            resolution_mm=self._hello.resolution_mm,
            time_s=await self._clock.now_s(),
            temperature_c=reading.temperature_c,
            sequence=reading.sequence,
        )

    async def _take_what_came(self) -> BridgeReading | None:
        """Take every line that is there and return the newest value."""
        newest = None
        async for line in self._lines.arrived():
            newest = self._take(line) or newest
        return newest

    async def _next_value(self) -> BridgeReading:
        silence = (
            f"the ballbar bridge at {self._lines.address} sends no value for"
            f" {self._value_timeout_s:g} s: check that the manufacturer's software reads the ballbar"
        )
        self._lines.expect(self._value_timeout_s, silence)
        while (reading := self._take(await self._lines.next())) is None:
            pass
        return reading

    def _take(self, line: bytes) -> BridgeReading | None:
        message = decode(line)
        if isinstance(message, Hello):
            self._hello = message
            return None
        # A program that hangs repeats its last value; only the count tells it from a bar that is steady.
        self._require_new(message.sequence)
        if abs(message.deviation_mm) > self._hello.range_mm:  # a NaN is not
            raise BridgeProtocolError(
                f"deviation_mm is {message.deviation_mm:g}, but the bridge announced a range_mm of"
                f" {self._hello.range_mm:g}: are these millimetres?"
            )
        return message

    def _require_new(self, sequence: int | None) -> None:
        """See that values are counted up; raises BridgeProtocolError."""
        if sequence is None:
            return
        if self._last is not None and sequence <= self._last:
            raise BridgeProtocolError(
                f"the ballbar bridge at {self._lines.address} sends value {sequence} after {self._last}:"
                " it repeats itself; restart it"
            )
        self._last = sequence


def _open(options: Options, clock: Clock) -> BridgedBallbar:
    return BridgedBallbar(tcp_link(options, PORT), clock)


_OPTIONS = {
    "host": "address of the computer on which the bridge runs",
    "port": f"TCP port of the bridge, default {PORT}",
}
PLUGIN = DriverPlugin("ballbar_bridge", "ballbar", "ballbar_bridge", _OPTIONS, _open, also=("linear_gauge",))
