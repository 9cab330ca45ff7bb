"""What a tracker with an emScon server is to whoever measures with it, be it points or poses.

Connecting, saying who it is, starting up, settings in the house's units, and one stationary measurement that
is new, and during which nobody changed what its numbers mean.
"""

import contextlib
import math
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass

from truepose_drivers.api import Clock, DeviceIdentity, Vector
from truepose_drivers.errors import (
    BusyError,
    ConfigurationError,
    DeviceRefusedError,
    NotInitialisedError,
    RemoteProtocolError,
)
from truepose_drivers.leica_emscon.conversation import Subject, TrackerConversation
from truepose_drivers.leica_emscon.coordinate_settings import (
    OWN_FRAME,
    RIGHT_HANDED,
    TELLING_CHANGES,
    UNITS,
    CoordinateSettings,
    Setting,
)
from truepose_drivers.leica_emscon.error_codes import CommandUnknownError
from truepose_drivers.leica_emscon.protocol import EXCHANGES, Command, Record, Request, Value
from truepose_drivers.leica_emscon.protocol.equipment import LTSensorType, TrackerProcessorStatus
from truepose_drivers.leica_emscon.protocol.settings import SystemParameter, WeatherMonitorStatus
from truepose_drivers.transports.link import Link, OnePortDevice, introduction

_MANUFACTURER = "Leica Geosystems"
_MOST_TRIES = 2  # of a measurement during which somebody changed the tracker
_REMEMBERED_RESULTS = 64
_SAME_PLACE_MM = 1.0  # a single sample's noise, by far; an earlier stop is further away

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
    """How long answers may take, in wall time, of a tracker that shows signs of life meanwhile.

    Both known clients allow as much for a command and for starting up.
    """

    initialise_s: float = 90.0
    command_s: float = 30.0
    result_s: float = 10.0  # besides the time that is measured: distances are tried again


class EmsconInstrument(OnePortDevice, ABC):
    """An emScon server on a link. Keeps the conversation; computes nothing."""

    def __init__(self, link: Link, clock: Clock, subject: Subject, time_outs: TimeOuts | None) -> None:
        super().__init__(link)
        self._conversation = TrackerConversation(link, subject)
        self._clock = clock
        self._time_outs = time_outs or TimeOuts()
        self._prepared = False
        self._measure_ms: int | None = None
        self._measures = ""
        self._settled = CoordinateSettings(self._ask)
        self._earlier: deque[_AcceptedResult] = deque(maxlen=_REMEMBERED_RESULTS)

    @abstractmethod
    def _require_fit(self, values: Record) -> None:
        """Raise RemoteProtocolError for a result that is none of what is measured."""

    @abstractmethod
    async def _place_of(self, values: Record) -> Vector | None:
        """Return where the reflector was when this was measured, None where that cannot be known."""

    @property
    def settings(self) -> str:
        """What it measures, as read back when it was last initialised."""
        return self._measures

    async def connect(self) -> None:
        """Open the link and see that a tracker is there, to be initialised; raises ConnectFailedError.

        Raises DeviceRefusedError where another program has the tracker.
        """
        self._prepared = False
        await self._conversation.open()
        async with introduction(self._port):
            await self._ask(Command.GET_SYSTEM_STATUS)

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

    async def _prepare(self, mode: Record) -> None:
        """Start up, and set what coordinates mean; `_settle` ends what begins here."""
        self._prepared = False
        self._measures = ""
        await self._learn_whether_it_queues()
        # Before anything that carries a length: a tracker that was switched off speaks metres.
        await self._ask(Command.SET_UNITS, UNITS)
        await self._start_up()
        await self._ask(Command.SET_MEASUREMENT_MODE, mode)
        await self._ask(Command.SET_COORDINATE_SYSTEM_TYPE, RIGHT_HANDED)
        await self._ask(Command.SET_SYSTEM_SETTINGS, Record(await self._settings() | _OWN_SETTINGS))

    async def _settle(self, measures: str, *own: Setting) -> None:
        """Read back what was set, and what besides must stay as it is, so that `measures` holds."""
        await self._settled.settle(own)
        self._conversation.take_changes()  # our own
        self._measures = measures
        self._measure_ms = None
        self._prepared = True

    async def _learn_whether_it_queues(self) -> None:
        """See whether a tracker that is busy says so; one that queues commands keeps silent."""
        size = Record(system_param=SystemParameter.TCP_COMMAND_QUEUE_SIZE)
        with contextlib.suppress(DeviceRefusedError):
            queue = await self._ask(Command.GET_LONG_SYSTEM_PARAMETER, size)
            queues = queue["system_param"] == size["system_param"] and queue.integer("parameter") > 0
            self._conversation.answers_while_busy = not queues

    async def _ask(self, command: Command, values: Record | None = None) -> Record:
        request = Request(command, values or Record())
        return await self._conversation.ask(request, timeout_s=self._time_outs.command_s)

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
        # Starting up takes up to minutes, and is needed once after the tracker was switched on.
        if await self._is_started_up():
            return
        await self._conversation.ask(Request(Command.INITIALIZE), timeout_s=self._time_outs.initialise_s)
        if not await self._is_started_up():
            raise NotInitialisedError(
                "the tracker did not come up after Initialize: check its own status display"
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

    async def _set_duration(self, duration_s: float) -> None:
        if not (math.isfinite(duration_s) and duration_s >= 0.001):
            raise ConfigurationError(f"a measurement of {duration_s} s is too short: give at least 0.001 s")
        measure_ms = round(1000.0 * duration_s)
        if measure_ms == self._measure_ms:
            return
        params = Record(meas_time=measure_ms, use_adm=True)
        await self._ask(Command.SET_STATIONARY_MODE_PARAMS, params)
        self._measure_ms = measure_ms

    async def _require_prepared(self) -> None:
        if not self._prepared:
            # Also where a program before us had started it up: its units, frame and reflector are not known
            # to be ours.
            raise NotInitialisedError(
                "the tracker has not been initialised since it was connected: initialise it first"
            )
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
        await self._set_duration(duration_s)
        for _ in range(_MOST_TRIES):
            values = await self._conversation.measure(
                accept_s=self._time_outs.command_s, result_s=duration_s + self._time_outs.result_s
            )
            await self._require_settled()
            # Announcements of what happened during the measurement stand before its result; a change that was
            # set back in time is found by them alone.
            if not self._conversation.take_changes() & TELLING_CHANGES:
                await self._require_new(values)
                return values
            await self._require_settled(everything=True)
        raise BusyError(
            "another program changed settings of the tracker during a measurement: close that program"
        )

    async def _require_new(self, values: Record) -> None:
        """See that a result is of what was asked for, and none of an earlier measurement."""
        try:
            self._require_fit(values)
            taken = _AcceptedResult(tuple(values.items()), await self._place_of(values))
            earlier = next((one for one in self._earlier if one.members == taken.members), None)
            if earlier is not None and not await self._stands_at(earlier.place_mm):
                raise RemoteProtocolError(
                    "the tracker sent the result of an earlier measurement again: connect again"
                )
        except RemoteProtocolError:
            await self.close()
            raise
        self._earlier.append(taken)

    async def _stands_at(self, place_mm: Vector | None) -> bool:
        """Whether the reflector is there now: an instrument without noise repeats itself, and is right."""
        now_mm = await self._prism_mm()
        if place_mm is None or now_mm is None:
            return False
        return math.dist(now_mm, place_mm) <= _SAME_PLACE_MM

    async def _prism_mm(self) -> Vector | None:
        """Return where the tracker sees the reflector now, None where it sees none or does not tell."""
        try:
            return (await self._ask(Command.GET_CURRENT_PRISM_POSITION)).vector()
        except DeviceRefusedError:
            return None


@dataclass(frozen=True, slots=True)
class _AcceptedResult:
    """A result that was believed."""

    members: tuple[tuple[str, Value], ...]
    place_mm: Vector | None  # of the reflector


def require_deviations(values: Record, *names: str) -> None:
    """See that members are standard deviations, or NaN where none is stated; raises RemoteProtocolError."""
    stated = {name: values.number(name) for name in names}
    if any(deviation < 0.0 or math.isinf(deviation) for deviation in stated.values()):
        raise RemoteProtocolError(f"the tracker reports standard deviations of {stated}: connect again")


def _sensor_name(tracker_type: int) -> str:
    known = {int(member): member.name for member in LTSensorType}
    return known.get(tracker_type, f"emScon laser tracker of type {tracker_type}").replace("_", " ")
