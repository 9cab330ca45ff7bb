"""A tracker behind a bridge: a program of the shop's that speaks to the maker's software."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final, Literal, TypeVar, cast

from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    Environment,
    Options,
    PoseReading,
    Quaternion,
    TrackerReading,
    Vector,
)
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    BeamBrokenError,
    BusyError,
    ConfigurationError,
    DeviceRefusedError,
    DriverError,
    MeasurementFailedError,
    NoReplyError,
    NotInitialisedError,
    OutOfVolumeError,
    ReflectorNotFoundError,
)
from truepose_drivers.framing import LineReader
from truepose_drivers.json_bridge import protocol
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OnePortDevice, introduction
from truepose_drivers.transports.tcp import tcp_link

Values = Mapping[str, object]
_NOT_STATED = (math.nan, math.nan, math.nan)


def point_of(values: Values) -> TrackerReading:
    """Return a point, whose time and duration the asker knows; raises BridgeError."""
    return TrackerReading(
        point_mm=_vector(values, "point_mm"),
        standard_deviation_mm=_stated(values, "deviation_mm"),
        rms_mm=_scatter_mm(values),
        samples=_whole(values, "samples"),
        duration_s=math.nan,
        face=_face(values),
        time_s=math.nan,
        covariance_mm2=_covariance(values),
    )


def pose_of(values: Values) -> PoseReading:
    """Return a pose, whose time and duration the asker knows; raises BridgeError."""
    return PoseReading(
        quaternion=cast(Quaternion, protocol.numbers(values, "quaternion", 4)),
        position_mm=_vector(values, "position_mm"),
        position_deviation_mm=_stated(values, "deviation_mm"),
        rotation_deviation_rad=_optional(values, "rotation_deviation_rad"),
        rms_mm=_optional(values, "rms_mm"),
        frames=_whole(values, "frames"),
        duration_s=math.nan,
        time_s=math.nan,
    )


def air_of(values: Values) -> Environment:
    """Return the air; NaN for what the instrument does not measure. Raises BridgeError."""
    return Environment(
        protocol.number(values, "temperature_c"),
        _optional(values, "pressure_hpa"),
        _optional(values, "humidity_percent"),
    )


def _vector(values: Values, key: str) -> Vector:
    return cast(Vector, protocol.numbers(values, key, 3))


def _stated(values: Values, key: str) -> Vector:
    return _NOT_STATED if values.get(key) is None else _vector(values, key)


def _optional(values: Values, key: str) -> float:
    return math.nan if values.get(key) is None else protocol.number(values, key)


def _scatter_mm(values: Values) -> float:
    """Return the total scatter, from the deviations where it is not stated; one of them must be."""
    if values.get("rms_mm") is None and values.get("deviation_mm") is None:
        raise protocol.BridgeError(
            "neither rms_mm nor deviation_mm is given: the scatter of the samples is missing"
        )
    if values.get("rms_mm") is None:
        return math.hypot(*_vector(values, "deviation_mm"))
    return protocol.number(values, "rms_mm")


def _whole(values: Values, key: str) -> int:
    """Return how many were averaged, one where nothing is said."""
    count = values.get(key, 1)
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count < 2**31:
        raise protocol.BridgeError(f"{key} is {repr(count)[:40]}; expected a whole number from 1")
    return count


def _face(values: Values) -> Literal[1, 2]:
    """Return the face, the first where the instrument has one only."""
    match values.get("face", 1):
        case bool():
            pass
        case 1:
            return 1
        case 2:
            return 2
    raise protocol.BridgeError(f"face is {values['face']!r:.40}; expected 1 or 2")


def _covariance(values: Values) -> tuple[Vector, Vector, Vector] | None:
    """Return xx, yy, zz, xy, xz, yz as a matrix, None where they are not given."""
    if values.get("covariance_mm2") is None:
        return None
    xx, yy, zz, xy, xz, yz = protocol.numbers(values, "covariance_mm2", 6)
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


Value = TypeVar("Value")

PORT: Final = 7421  # ours, and free to choose: no registry lists it
_QUIET_S: Final = 1.8  # without a line; a bridge that is at work says so every second
_PATIENCE_S: Final = 60.0  # with a bridge that says that it is at work, besides the time that is measured
_WARM_UP_S: Final = 600.0
_FAILURES: Mapping[str, type[DriverError]] = {
    "beam_broken": BeamBrokenError,
    "reflector_not_found": ReflectorNotFoundError,
    "artefact_not_seen": ArtefactNotSeenError,
    "out_of_volume": OutOfVolumeError,
    "measurement_failed": MeasurementFailedError,
    "not_initialised": NotInitialisedError,
    "busy": BusyError,
    "refused": DeviceRefusedError,
}


class BridgedTracker(OnePortDevice):
    """An instrument bridge on a link: measures points, poses or both, as its instrument does."""

    def __init__(self, link: Link, clock: Clock) -> None:
        self._lines: Conversation[bytes] = Conversation(
            link, LineReader, harmless=(DeviceRefusedError, MeasurementFailedError)
        )
        super().__init__(self._lines)
        self._clock = clock
        self._asked = 0  # questions on this connection
        self._serial: str | None = None  # of the instrument that was initialised
        self._newest = 0  # number of the newest measurement
        self._measures = ""

    @property
    def settings(self) -> str:
        """What the instrument measures with, as the bridge said when it was last initialised."""
        return self._measures

    async def connect(self) -> None:
        """Open the link and ask who is there; raises ConnectFailedError."""
        self._asked, self._serial, self._measures = 0, None, ""
        await self._lines.open()
        async with introduction(self._lines):
            await self.identify()

    async def identify(self) -> DeviceIdentity:
        """Ask the bridge what instrument it speaks for."""
        return await self._ask("hello", _identity)

    async def initialise(self) -> None:
        """Have the instrument made ready; what is measured comes in its own frame."""
        self._serial = None
        # The serial number is forgotten beforehand: an initialisation that breaks off leaves nothing ready.
        ready = await self._ask("initialise", _ready, longest_s=_WARM_UP_S)
        # The count goes on from here, so that a value frozen before the instrument was ready is refused too.
        self._measures, self._newest, self._serial = ready

    async def find_reflector(self, near_mm: Vector, *, search_radius_mm: float) -> None:
        """Point at `near_mm` and lock on the reflector there; raises ReflectorNotFoundError."""
        if not all(map(math.isfinite, (*near_mm, search_radius_mm))) or search_radius_mm <= 0.0:
            raise ConfigurationError(f"no instrument can search at {near_mm} within {search_radius_mm} mm")
        details = {"near_mm": list(near_mm), "radius_mm": search_radius_mm}
        await self._ask("find_reflector", self._of_ours, details)

    async def measure_point(self, *, duration_s: float) -> TrackerReading:
        """Measure the reflector locked on; raises BeamBrokenError."""
        values = await self._measure("measure_point", duration_s, point_of)
        return replace(values, duration_s=duration_s, time_s=await self._clock.now_s())

    async def measure_pose(self, *, duration_s: float) -> PoseReading:
        """Measure the artefact; raises ArtefactNotSeenError, OutOfVolumeError."""
        values = await self._measure("measure_pose", duration_s, pose_of)
        return replace(values, duration_s=duration_s, time_s=await self._clock.now_s())

    async def change_face(self) -> None:
        """Turn to the other face; raises DeviceRefusedError where the instrument has one only."""
        await self._ask("change_face", self._of_ours)

    async def environment(self) -> Environment:
        """Read the weather station; raises DeviceRefusedError where there is none."""
        return await self._ask("environment", lambda answer: air_of(self._of_ours(answer).values))

    async def _measure(
        self, ask: protocol.Ask, duration_s: float, decode: Callable[[Mapping[str, object]], Value]
    ) -> Value:
        """Have a measurement made that none before was."""
        if not (math.isfinite(duration_s) and duration_s > 0.0):
            raise ConfigurationError(f"nothing can be measured in {duration_s} s")

        def new(answer: protocol.Answer) -> Value:
            self._require_new(protocol.measurement_number(self._of_ours(answer)))
            return decode(answer.values)

        details = {"duration_s": duration_s}
        return await self._ask(ask, new, details, longest_s=duration_s + _PATIENCE_S)

    def _require_new(self, sequence: int) -> None:
        """See that measurements are counted up, from what the bridge said when it was initialised."""
        if sequence <= self._newest:
            raise protocol.BridgeError(
                f"the bridge sends measurement {sequence} after {self._newest}: it repeats itself; take the"
                " count from the instrument or from the clock"
            )
        self._newest = sequence

    def _of_ours(self, answer: protocol.Answer) -> protocol.Answer:
        """Return an answer of the instrument that was initialised; raises NotInitialisedError."""
        if answer.serial != self._serial:
            # Points of another instrument lie in another frame: nothing is measured before it was
            # initialised, and before a person has accepted it.
            before, self._serial = self._serial, None
            raise NotInitialisedError(
                f"a different instrument answers: {answer.serial}, but {before} was initialised: initialise"
                " it"
            )
        return answer

    async def _ask(
        self,
        ask: protocol.Ask,
        decode: Callable[[protocol.Answer], Value],
        details: Mapping[str, object] = MappingProxyType({}),
        *,
        longest_s: float = _PATIENCE_S,
    ) -> Value:
        if self._serial is None and ask not in ("hello", "initialise"):
            raise NotInitialisedError(
                "it has not been initialised since it was connected or exchanged: initialise it"
            )
        async with self._lines.turn():
            await self._pass_over_busy()
            self._asked += 1
            question = protocol.encode_question(protocol.Question(self._asked, ask, details))
            await self._lines.send(question, timeout_s=longest_s, silence=self._silence(ask))
            answer = await self._answer(ask)
            await self._pass_over_busy()
            return decode(answer)

    async def _answer(self, ask: protocol.Ask) -> protocol.Answer:
        while True:
            line = await self._lines.next_within(_QUIET_S)
            if line is None:
                raise NoReplyError(self._silence(ask))
            match protocol.decode_reply(line):
                case protocol.Busy():
                    continue
                case protocol.Answer() | protocol.Failure() as reply if reply.number != self._asked:
                    raise protocol.BridgeError(
                        f"the bridge answered question {reply.number}, {self._asked} was asked"
                    )
                case protocol.Failure(_, kind, sentence):
                    # A word that we do not know counts as a refusal, which leaves the link open for the next
                    # question.
                    raise _FAILURES.get(kind, DeviceRefusedError)(sentence)
                case protocol.Answer() as answer:
                    return answer

    async def _pass_over_busy(self) -> None:
        """Read what arrived unasked: that it was at work, and nothing else."""
        async for line in self._lines.arrived():
            if not isinstance(protocol.decode_reply(line), protocol.Busy):
                raise protocol.BridgeError(
                    f"the bridge at {self._lines.address} sent more data than requested"
                )

    def _silence(self, ask: protocol.Ask) -> str:
        return (
            f"the bridge at {self._lines.address} did not answer {ask}: check that it and the manufacturer's"
            " software are running, then connect again"
        )


def _identity(hello: protocol.Answer) -> DeviceIdentity:
    version = hello.values.get("version")
    if version != protocol.VERSION:
        raise protocol.BridgeError(
            f"the bridge uses version {version!r}, truepose {protocol.VERSION}: update the older of the two"
        )
    manufacturer, model, firmware = (
        protocol.text(hello.values, key) for key in ("manufacturer", "model", "firmware")
    )
    return DeviceIdentity(manufacturer, model, hello.serial, firmware)


def _ready(answer: protocol.Answer) -> tuple[str, int, str]:
    """Return what the instrument measures with, how far its measurements are counted, and which it is."""
    settings = answer.values.get("settings")
    return (
        ("" if settings is None else protocol.text(answer.values, "settings")),
        protocol.newest_measurement(answer),
        answer.serial,
    )


def _open(options: Options, clock: Clock) -> BridgedTracker:
    return BridgedTracker(tcp_link(options, PORT), clock)


_OPTIONS = {
    "host": "address of the computer on which the bridge runs",
    "port": f"TCP port of the bridge, default {PORT}",
}
PLUGIN = DriverPlugin("json_bridge", "tracker", "json_bridge", _OPTIONS, _open, also=("pose_tracker",))
