"""A Leica laser tracker that speaks emScon: stationary measurements of one reflector at a time."""

import contextlib
import math
from collections import deque
from dataclasses import dataclass
from typing import Literal

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
    BusyError,
    ConfigurationError,
    DeviceRefusedError,
    NotInitialisedError,
    RemoteProtocolError,
)
from truepose_drivers.leica_emscon.conversation import TrackerConversation
from truepose_drivers.leica_emscon.protocol import DEFAULT_PORT, EXCHANGES, Command, Record, Request, Value
from truepose_drivers.leica_emscon.protocol.equipment import LTSensorType, TrackerFace, TrackerProcessorStatus
from truepose_drivers.leica_emscon.protocol.settings import StatisticMode, WeatherMonitorStatus
from truepose_drivers.leica_emscon.sentences import CommandUnknownError
from truepose_drivers.leica_emscon.settled import (
    OWN_FRAME,
    RIGHT_HANDED,
    STATIONARY_MODE,
    TELLING_CHANGES,
    UNITS,
    Settled,
)
from truepose_drivers.leica_emscon.stationary import require_stationary_point, stated_covariance
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import tcp_link

_MANUFACTURER = "Leica Geosystems"
_MOST_TRIES = 2  # of a measurement during which somebody changed the tracker
_REMEMBERED_RESULTS = 64
_SAME_PLACE_MM = 1.0  # a single sample's noise, by far; an earlier stop is further away
_SEARCH_TIMEOUT_MS = 10_000  # of the tracker's own spiral search; well within the answer's time-out

# The distance is corrected for the air. A position stream would only stand in the way of answers.
_OWN_SETTINGS = Record(
    OWN_FRAME,
    weather_monitor_status=WeatherMonitorStatus.READ_AND_CALCULATE_REFRACTIONS,
    keep_last_position=True,
    send_unsolicited_messages=True,
    send_reflector_position_data=False,
)


@dataclass(frozen=True, slots=True)
class TimeOuts:
    """How long answers may take, in wall time; both known clients allow the same."""

    initialise_s: float = 90.0
    command_s: float = 30.0


class LaserTracker:
    """An emScon tracker on a link. Keeps the conversation; computes nothing.

    `reflector` is the name of a reflector stored in the tracker; without it the one set there is used.
    """

    def __init__(
        self, link: Link, clock: Clock, *, reflector: str | None = None, time_outs: TimeOuts | None = None
    ) -> None:
        self._conversation = TrackerConversation(link)
        self._clock = clock
        self._reflector = reflector
        self._time_outs = time_outs or TimeOuts()
        self._prepared = False
        self._measure_ms: int | None = None
        self._search_radius_mm: float | None = None
        self._settled = Settled(self._ask)
        self._earlier: deque[tuple[tuple[str, Value], ...]] = deque(maxlen=_REMEMBERED_RESULTS)

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._conversation.is_open

    async def connect(self) -> None:
        """Open the link; raises ConnectFailedError. The tracker must be initialised afterwards."""
        self._prepared = False
        await self._conversation.open()

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._conversation.close()

    async def identify(self) -> DeviceIdentity:
        """Ask for model, serial number and firmware."""
        status = await self._ask(Command.GET_SYSTEM_STATUS)
        versions = ("major_version_number", "minor_version_number", "build_number")
        return DeviceIdentity(
            manufacturer=_MANUFACTURER,
            model=await self._model(),
            serial=str(status.integer("tracker_serial_number")),
            firmware=".".join(str(status.integer(name)) for name in versions),
        )

    async def initialise(self) -> None:
        """Set units, mode and frame; start up the tracker where it is not initialised yet.

        Raises NotInitialisedError when it does not come up, ConfigurationError for a reflector that it
        does not know, DeviceRefusedError when it cannot (not levelled, no weather station ...).
        """
        self._prepared = False
        await self._ask(Command.SET_UNITS, UNITS)
        await self._start_up()
        await self._ask(Command.SET_MEASUREMENT_MODE, STATIONARY_MODE)
        await self._ask(Command.SET_COORDINATE_SYSTEM_TYPE, RIGHT_HANDED)
        await self._ask(Command.SET_SYSTEM_SETTINGS, Record(await self._settings() | _OWN_SETTINGS))
        await self._ask_for_covariances()
        await self._choose_reflector()
        await self._settled.settle()
        self._conversation.take_changes()  # our own
        self._measure_ms = None
        self._search_radius_mm = None
        self._prepared = True

    async def find_reflector(self, near_mm: Vector, *, search_radius_mm: float) -> None:
        """Point at `near_mm` (tracker frame), lock on the reflector there; raises ReflectorNotFoundError."""
        await self._require_prepared()
        distance_mm = _checked_distance_mm(near_mm)
        await self._set_search_radius(search_radius_mm)
        x, y, z = near_mm
        aim = Record(val1=x, val2=y, val3=z, use_adm=True)
        await self._find(Request(Command.GO_POSITION, aim))
        # GoPosition may end aimed at an empty place; only the search says for certain that it locked.
        await self._find(Request(Command.FIND_REFLECTOR, Record(aprox_distance=distance_mm)))

    async def measure_point(self, *, duration_s: float) -> TrackerReading:
        """Average over `duration_s` the position of the reflector locked on; raises BeamBrokenError."""
        await self._require_prepared()
        await self._set_duration(duration_s)
        values = await self._measured(duration_s)
        time_s = await self._clock.now_s()
        return TrackerReading(
            point_mm=values.vector(),
            standard_deviation_mm=values.vector("std1", "std2", "std3"),
            rms_mm=values.number("std_total"),
            samples=1,  # emScon averages inside and does not say over how many
            duration_s=duration_s,
            face=await self._asked_face(),
            time_s=time_s,
            covariance_mm2=stated_covariance(values),
        )

    async def change_face(self) -> None:
        """Turn to the other face, which stays locked on the same reflector; raises ReflectorNotFoundError."""
        await self._require_prepared()
        before = await self._asked_face()
        await self._find(Request(Command.CHANGE_FACE))
        if await self._asked_face() == before:
            raise DeviceRefusedError(
                f"the tracker still stands in face {before} after ChangeFace: it may have only one"
            )

    async def environment(self) -> Environment:
        """Read the weather station."""
        await self._require_prepared()
        air = await self._ask(Command.GET_ENVIRONMENT_PARAMS)
        if self._conversation.take_changes() & TELLING_CHANGES:
            await self._require_settled(everything=True)
        return Environment(air.number("temperature"), air.number("pressure"), air.number("humidity"))

    async def _ask(self, command: Command, values: Record | None = None) -> Record:
        request = Request(command, values or Record())
        return await self._conversation.ask(request, timeout_s=self._time_outs.command_s)

    async def _find(self, request: Request) -> None:
        await self._conversation.ask(request, timeout_s=self._time_outs.command_s, purpose="find")

    async def _model(self) -> str:
        """Return the tracker's name; servers know one or the other of the two commands, or neither."""
        for command in (Command.GET_TRACKER_INFO, Command.GET_AT4XX_INFO):
            try:
                info = await self._ask(command)
            except DeviceRefusedError:
                continue
            return info.text("tracker_name") or _sensor_name(info.integer("tracker_type"))
        return "emScon laser tracker"

    async def _start_up(self) -> None:
        if await self._is_started_up():
            return
        await self._conversation.ask(Request(Command.INITIALIZE), timeout_s=self._time_outs.initialise_s)
        if not await self._is_started_up():
            raise NotInitialisedError(
                "the tracker did not come up after Initialize: look at its own status display"
            )

    async def _is_started_up(self) -> bool:
        status = await self._ask(Command.GET_SYSTEM_STATUS)
        return status.integer("tracker_processor_status") == TrackerProcessorStatus.INITIALIZED

    async def _settings(self) -> Record:
        """Return the present settings, whose equipment flags must stay as they are."""
        try:
            return await self._ask(Command.GET_SYSTEM_SETTINGS)
        except CommandUnknownError:
            return EXCHANGES[Command.GET_SYSTEM_SETTINGS].answer.zeros()

    async def _choose_reflector(self) -> None:
        items = await self._conversation.ask_list(Command.GET_REFLECTORS, timeout_s=self._time_outs.command_s)
        stored = {item.text("reflector_name"): item.integer("internal_reflector_id") for item in items}
        number = await self._reflector_number(stored)
        await self._ask(Command.SET_REFLECTOR, Record(internal_reflector_id=number))

    async def _reflector_number(self, stored: dict[str, int]) -> int:
        if self._reflector is not None:
            if self._reflector not in stored:
                raise ConfigurationError(
                    f"the tracker has no reflector named {self._reflector!r}; it has {_names(stored)}"
                )
            return stored[self._reflector]
        if len(stored) == 1:
            return next(iter(stored.values()))
        current = (await self._ask(Command.GET_REFLECTOR)).integer("internal_reflector_id")
        if current in stored.values():
            return current
        raise ConfigurationError(
            f"no reflector is set in the tracker: name one of {_names(stored)} in option reflector"
        )

    async def _set_search_radius(self, radius_mm: float) -> None:
        if not (math.isfinite(radius_mm) and radius_mm > 0.0):
            raise ConfigurationError(f"a search radius of {radius_mm} mm finds nothing: give a positive one")
        if radius_mm == self._search_radius_mm:
            return
        params = Record(search_radius=radius_mm, time_out=_SEARCH_TIMEOUT_MS)
        await self._ask(Command.SET_SEARCH_PARAMS, params)
        self._search_radius_mm = radius_mm

    async def _set_duration(self, duration_s: float) -> None:
        if not (math.isfinite(duration_s) and duration_s >= 0.001):
            raise ConfigurationError(f"a measurement of {duration_s} s is too short: give at least 0.001 s")
        measure_ms = round(1000.0 * duration_s)
        if measure_ms == self._measure_ms:
            return
        params = Record(meas_time=measure_ms, use_adm=True)
        await self._ask(Command.SET_STATIONARY_MODE_PARAMS, params)
        self._measure_ms = measure_ms

    async def _asked_face(self) -> Literal[1, 2]:
        match (await self._ask(Command.GET_FACE)).integer("tracker_face"):
            case TrackerFace.FACE_1:
                return 1
            case TrackerFace.FACE_2:
                return 2
            case other:
                raise RemoteProtocolError(f"the tracker says it stands in face {other}; 1 or 2 was expected")

    async def _ask_for_covariances(self) -> None:
        """Have results carry the covariance of the point; older trackers state deviations only."""
        extended = Record(
            stationary_measurements=StatisticMode.EXTENDED, continuous_measurements=StatisticMode.STANDARD
        )
        with contextlib.suppress(CommandUnknownError):
            await self._ask(Command.SET_STATISTIC_MODE, extended)

    async def _require_prepared(self) -> None:
        if not self._prepared:
            raise NotInitialisedError("the tracker was not initialised since it was connected: do so first")
        if self._conversation.take_changes() & TELLING_CHANGES:
            await self._require_settled(everything=True)

    async def _require_settled(self, *, everything: bool = False) -> None:
        """See that a coordinate still means what it did; raises NotInitialisedError."""
        try:
            await self._settled.require(everything=everything)
        except NotInitialisedError:
            self._prepared = False
            raise

    async def _measured(self, duration_s: float) -> Record:
        """Measure until nobody changed the tracker meanwhile; raises BusyError where somebody always does."""
        for _ in range(_MOST_TRIES):
            result = await self._conversation.measure(timeout_s=self._time_outs.command_s + duration_s)
            await self._require_settled()
            if not self._conversation.take_changes() & TELLING_CHANGES:
                await self._require_new(result.values)
                return result.values
            await self._require_settled(everything=True)
        raise BusyError("another program changes the tracker while it measures: close that program")

    async def _require_new(self, values: Record) -> None:
        """See that a result is a stationary point, and none of an earlier measurement."""
        fingerprint = tuple(values.items())
        try:
            require_stationary_point(values)
            if fingerprint in self._earlier and not await self._stands_at(values.vector()):
                raise RemoteProtocolError(
                    "the tracker sent the result of an earlier measurement again: connect again"
                )
        except RemoteProtocolError:
            await self.close()
            raise
        self._earlier.append(fingerprint)

    async def _stands_at(self, point_mm: Vector) -> bool:
        """Whether the reflector is there now: an instrument without noise repeats itself, and is right."""
        try:
            now = await self._ask(Command.GET_CURRENT_PRISM_POSITION)
        except DeviceRefusedError:
            return False
        return math.dist(now.vector(), point_mm) <= _SAME_PLACE_MM


def _checked_distance_mm(point_mm: Vector) -> float:
    distance_mm = math.hypot(*point_mm)
    if not (math.isfinite(distance_mm) and distance_mm > 0.0):
        raise ConfigurationError(f"the tracker cannot point at {point_mm}: give a point away from its centre")
    return distance_mm


def _sensor_name(tracker_type: int) -> str:
    known = {int(member): member.name for member in LTSensorType}
    return known.get(tracker_type, f"emScon laser tracker of type {tracker_type}").replace("_", " ")


def _names(stored: dict[str, int]) -> str:
    return ", ".join(sorted(stored)) or "none at all"


def _open(options: Options, clock: Clock | None) -> LaserTracker:
    link = tcp_link(options, DEFAULT_PORT)
    return LaserTracker(link, clock or MonotonicClock(), reflector=option.text(options, "reflector"))


_OPTIONS = {
    "host": "address of the tracker controller, often 192.168.0.1",
    "port": f"TCP port, {DEFAULT_PORT} unless changed",
    "reflector": "name of the reflector as stored in the tracker; the one set there if left out",
}
PLUGIN = DriverPlugin("leica_emscon", "tracker", "emscon", _OPTIONS, _open)
