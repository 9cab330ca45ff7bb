"""The conversation with an ACME tracker; what a word means is in `protocol`."""

from typing import Literal

from acme_tracker.protocol import LineReader, Reply, decode, encode
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
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import TcpLink

_ANSWER_TIMEOUT_S = 10.0  # wall time


class AcmeTracker:
    """An ACME tracker on a link. Keeps the conversation; computes nothing."""

    def __init__(self, link: Link, clock: Clock) -> None:
        # A refusal is an answer; whatever else goes wrong closes the link, for answers have no numbers.
        self._conversation = Conversation(link, LineReader, harmless=(DeviceRefusedError,))
        self._clock = clock
        self._face: Literal[1, 2] = 1

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._conversation.is_open

    async def connect(self) -> None:
        """Open the link; raises ConnectFailedError."""
        self._face = 1
        await self._conversation.open()

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._conversation.close()

    async def identify(self) -> DeviceIdentity:
        """Ask who it is."""
        model, serial, firmware = self._words(await self._ask("WHO"), "ACME", 3)
        return DeviceIdentity("ACME", model, serial, firmware)

    async def initialise(self) -> None:
        """Set millimetres: switched on, it speaks inches."""
        self._words(await self._ask("MODE_MM"), "OK", 0)

    async def find_reflector(self, near_mm: Vector, *, search_radius_mm: float) -> None:
        """Lock on the reflector near a point; raises ReflectorNotFoundError."""
        reply = await self._ask("AIM", *near_mm, search_radius_mm)
        if reply.word == "EMPTY":
            raise ReflectorNotFoundError(
                f"No reflector within {search_radius_mm:g} mm; check that it is in its nest and in sight."
            )
        self._words(reply, "LOCKED", 0)

    async def measure_point(self, *, duration_s: float) -> TrackerReading:
        """Measure the reflector locked on; raises BeamBrokenError."""
        reply = await self._ask("MEASURE", duration_s, timeout_s=duration_s + _ANSWER_TIMEOUT_S)
        if reply.word == "BEAM":
            raise BeamBrokenError("The beam was interrupted; clear it, then repeat the configuration.")
        self._words(reply, "POINT", 7)
        x, y, z, sx, sy, sz, rms = reply.numbers(7)
        return TrackerReading(
            point_mm=(x, y, z),
            standard_deviation_mm=(sx, sy, sz),
            rms_mm=rms,
            samples=1,  # it does not say how many it averaged
            duration_s=duration_s,
            face=self._face,
            time_s=await self._clock.now_s(),
        )

    async def change_face(self) -> None:
        """Turn to the other face."""
        self._words(await self._ask("FLIP"), "OK", 0)
        self._face = 2 if self._face == 1 else 1

    async def environment(self) -> Environment:
        """Read its weather station."""
        reply = await self._ask("AIR")
        self._words(reply, "AIR", 3)
        return Environment(*reply.numbers(3))

    def _words(self, reply: Reply, expected: str, count: int) -> tuple[str, ...]:
        if reply.word != expected or len(reply.rest) != count:
            raise RemoteProtocolError(f"the tracker answered {reply} where {expected} belongs")
        return reply.rest

    async def _ask(self, word: str, *values: float, timeout_s: float = _ANSWER_TIMEOUT_S) -> Reply:
        silence = f"the tracker at {self._conversation.address} says nothing for {timeout_s:g} s"
        return await self._conversation.ask(
            encode(word, *values), decode, timeout_s=timeout_s, silence=silence
        )


def _open(options: Options, clock: Clock | None) -> AcmeTracker:
    link = TcpLink(option.host(options), option.port(options, default=9000))
    return AcmeTracker(link, clock or MonotonicClock())


PLUGIN = DriverPlugin(
    name="acme_tracker",
    kind="tracker",
    protocol="acme",
    options={"host": "address of the tracker", "port": "TCP port, 9000 unless changed"},
    open=_open,
)
