"""The conversation with an ACME tracker; what a word means is in `protocol`."""

from acme_tracker.protocol import Reply, decode, encode, expected, finite, point
from truepose_drivers import options as option
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    Environment,
    Options,
    TrackerReading,
    Vector,
)
from truepose_drivers.errors import (
    BeamBrokenError,
    DeviceRefusedError,
    ReflectorNotFoundError,
    RemoteProtocolError,
)
from truepose_drivers.line_gauges.protocol import TextLines
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, introduction
from truepose_drivers.transports.tcp import TcpLink

_ANSWER_TIMEOUT_S = 1.8  # wall time: a tracker that is gone is told within two seconds
_SEARCH_TIMEOUT_S = 10.0  # it turns to the reflector meanwhile


class AcmeTracker:
    """An ACME tracker on a link. Keeps the conversation; computes nothing."""

    def __init__(self, link: Link, clock: Clock) -> None:
        # A refusal is an answer; whatever else goes wrong closes the link, for answers have no numbers.
        self._conversation = Conversation(link, lambda: TextLines(str), harmless=(DeviceRefusedError,))
        self._clock = clock
        self._number = -1  # of the last measurement of this connection

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._conversation.is_open

    async def connect(self) -> None:
        """Open the link and ask who is there; raises ConnectFailedError."""
        self._number = -1
        await self._conversation.open()
        async with introduction(self._conversation):
            await self.identify()

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._conversation.close()

    async def identify(self) -> DeviceIdentity:
        """Ask who it is."""
        model, serial, firmware = expected(await self._ask("WHO"), "ACME", 3)
        return DeviceIdentity("ACME", model, serial, firmware)

    async def initialise(self) -> None:
        """Set millimetres: switched on, it speaks inches."""
        expected(await self._ask("MODE_MM"), "OK", 0)

    async def find_reflector(self, near_mm: Vector, *, search_radius_mm: float) -> None:
        """Lock on the reflector near a point; raises ReflectorNotFoundError."""
        reply = await self._ask("AIM", *near_mm, search_radius_mm, timeout_s=_SEARCH_TIMEOUT_S)
        if reply.word == "EMPTY":
            raise ReflectorNotFoundError(
                f"No reflector within {search_radius_mm:g} mm; check that it is in its nest and in sight."
            )
        expected(reply, "LOCKED", 0)

    async def measure_point(self, *, duration_s: float) -> TrackerReading:
        """Measure the reflector locked on; raises BeamBrokenError."""
        reply = await self._ask("MEASURE", duration_s, timeout_s=duration_s + _ANSWER_TIMEOUT_S)
        if reply.word == "BEAM":
            raise BeamBrokenError("The beam was interrupted; clear it, then repeat the configuration.")
        measured = point(reply)
        await self._require_new(measured.number)
        x, y, z, sx, sy, sz, rms = measured.numbers
        return TrackerReading(
            point_mm=(x, y, z),
            standard_deviation_mm=(sx, sy, sz),
            rms_mm=rms,
            samples=1,  # it does not say how many it averaged
            duration_s=duration_s,
            face=measured.face,
            time_s=await self._clock.now_s(),
        )

    async def change_face(self) -> None:
        """Turn to the other face."""
        expected(await self._ask("FLIP", timeout_s=_SEARCH_TIMEOUT_S), "OK", 0)

    async def environment(self) -> Environment:
        """Read its weather station."""
        return Environment(*finite(expected(await self._ask("AIR"), "AIR", 3)))

    async def _require_new(self, number: int) -> None:
        """See that measurements are counted up; raises RemoteProtocolError."""
        if number <= self._number:
            await self.close()
            raise RemoteProtocolError(f"the tracker repeats measurement {number}: connect again")
        self._number = number

    async def _ask(self, word: str, *values: float, timeout_s: float = _ANSWER_TIMEOUT_S) -> Reply:
        silence = f"the tracker at {self._conversation.address} did not respond within {timeout_s:g} s"
        return await self._conversation.ask(
            encode(word, *values), decode, timeout_s=timeout_s, silence=silence
        )


def _open(options: Options, clock: Clock) -> AcmeTracker:
    link = TcpLink(option.host(options), option.port(options, default=9000))
    return AcmeTracker(link, clock)


PLUGIN = DriverPlugin(
    name="acme_tracker",
    kind="tracker",
    protocol="acme",
    options={"host": "address of the tracker", "port": "TCP port, 9000 unless changed"},
    open=_open,
)
