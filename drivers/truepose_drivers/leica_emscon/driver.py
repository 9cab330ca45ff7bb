"""A Leica laser tracker that speaks emScon: stationary measurements of one reflector at a time."""

import contextlib
import math
from typing import Literal

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DriverPlugin, Environment, Options, TrackerReading, Vector
from truepose_drivers.errors import ConfigurationError, DeviceRefusedError, RemoteProtocolError
from truepose_drivers.leica_emscon.conversation import Subject
from truepose_drivers.leica_emscon.coordinate_settings import COMPENSATION, TELLING_CHANGES, Setting, mode
from truepose_drivers.leica_emscon.error_codes import CommandUnknownError
from truepose_drivers.leica_emscon.instrument import EmsconInstrument, TimeOuts, require_deviations
from truepose_drivers.leica_emscon.protocol import DEFAULT_PORT, Command, PacketType, Record, Request
from truepose_drivers.leica_emscon.protocol.equipment import TargetType, TrackerFace
from truepose_drivers.leica_emscon.protocol.settings import MeasMode, StatisticMode
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import tcp_link

_POINTS = Subject(frozenset({PacketType.SINGLE_MEAS_RESULT, PacketType.SINGLE_MEAS_RESULT_2}), "measure")
_SEARCH_TIMEOUT_MS = 10_000  # of the tracker's own spiral search; well within the answer's time-out


class LaserTracker(EmsconInstrument):
    """An emScon tracker that measures points.

    `reflector` is the name of a reflector stored in the tracker; without it the one set there is used.
    """

    def __init__(
        self, link: Link, clock: Clock, *, reflector: str | None = None, time_outs: TimeOuts | None = None
    ) -> None:
        super().__init__(link, clock, _POINTS, time_outs)
        self._reflector = reflector
        self._search_radius_mm: float | None = None

    async def initialise(self) -> None:
        """Set units, mode, frame and reflector; start up the tracker where it is not initialised yet.

        Raises NotInitialisedError when it does not come up, ConfigurationError for a reflector that it
        does not know, DeviceRefusedError when it cannot (not levelled, no weather station ...).
        """
        await self._prepare(Record(meas_mode=MeasMode.STATIONARY))
        await self._ask_for_covariances()
        reflector = await self._chosen_reflector()
        number = Record(internal_reflector_id=reflector.integer("internal_reflector_id"))
        await self._ask(Command.SET_REFLECTOR, number)
        self._search_radius_mm = None
        await self._settle(
            _reflector_sentence(reflector),
            mode(MeasMode.STATIONARY),
            Setting("reflector", Command.GET_REFLECTOR, number),
            COMPENSATION,
        )

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
            covariance_mm2=_stated_covariance(values),
        )

    async def reflector_now(self) -> Vector | None:
        """Return one sample of where the reflector is (tracker frame), None where none is locked on.

        Asked for, not streamed: a stream would hide that an answer is lost, and comes three times a second.
        """
        return await self._prism_mm() if self.connected and self._prepared else None

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

    async def _find(self, request: Request) -> None:
        await self._conversation.ask(request, timeout_s=self._time_outs.command_s, purpose="find")

    async def _chosen_reflector(self) -> Record:
        """Return the one of the tracker's list that the cell names, or else the one that is set there."""
        items = await self._conversation.ask_list(Command.GET_REFLECTORS, timeout_s=self._time_outs.command_s)
        stored = {item.text("reflector_name"): item for item in items}
        if self._reflector is not None:
            if self._reflector not in stored:
                raise ConfigurationError(
                    f"the tracker has no reflector named {self._reflector!r}; it has {_names(stored)}"
                )
            return stored[self._reflector]
        if len(stored) == 1:
            return next(iter(stored.values()))
        current = (await self._ask(Command.GET_REFLECTOR))["internal_reflector_id"]
        for item in stored.values():
            if item["internal_reflector_id"] == current:
                return item
        raise ConfigurationError(
            f"no reflector is set in the tracker: name one of {_names(stored)} in option reflector"
        )

    async def _set_search_radius(self, radius_mm: float) -> None:
        if not (math.isfinite(radius_mm) and radius_mm > 0.0):
            raise ConfigurationError(
                f"a search radius of {radius_mm} mm finds nothing: enter a positive radius"
            )
        if radius_mm == self._search_radius_mm:
            return
        params = Record(search_radius=radius_mm, time_out=_SEARCH_TIMEOUT_MS)
        await self._ask(Command.SET_SEARCH_PARAMS, params)
        self._search_radius_mm = radius_mm

    async def _asked_face(self) -> Literal[1, 2]:
        match (await self._ask(Command.GET_FACE)).integer("tracker_face"):
            case TrackerFace.FACE_1:
                return 1
            case TrackerFace.FACE_2:
                return 2
            case other:
                raise RemoteProtocolError(f"the tracker reports face {other}; expected 1 or 2")

    async def _ask_for_covariances(self) -> None:
        """Have results carry the covariance of the point; older trackers state deviations only."""
        extended = Record(
            stationary_measurements=StatisticMode.EXTENDED, continuous_measurements=StatisticMode.STANDARD
        )
        with contextlib.suppress(CommandUnknownError):
            await self._ask(Command.SET_STATISTIC_MODE, extended)

    def _require_fit(self, values: Record) -> None:
        """Raise RemoteProtocolError for a result of another mode, or one that is no point."""
        if values.integer("meas_mode") != MeasMode.STATIONARY or values.integer("is_try_mode"):
            raise RemoteProtocolError("the tracker measured in a mode other than requested: initialise it")
        point = values.vector()
        if not all(map(math.isfinite, point)):
            raise RemoteProtocolError(f"the tracker measured {point}: not a valid point")
        require_deviations(values, "std1", "std2", "std3", "std_total")

    async def _place_of(self, values: Record) -> Vector:
        return values.vector()


def _stated_covariance(values: Record) -> tuple[Vector, Vector, Vector] | None:
    """Return the a-priori covariance, from the accuracy model; None where the server states no such thing."""
    u1, u2, u3 = values.vector("apriori_std1", "apriori_std2", "apriori_std3")
    if not all(math.isfinite(u) and u > 0.0 for u in (u1, u2, u3)):
        return None
    # The packet of standard statistics has deviations alone; only that of the extended ones has mixed terms.
    mixed = ("apriori_covar12", "apriori_covar13", "apriori_covar23")
    c12, c13, c23 = values.vector(*mixed) if mixed[0] in values else (0.0, 0.0, 0.0)
    return (u1 * u1, c12, c13), (c12, u2 * u2, c23), (c13, c23, u3 * u3)  # ** would raise where * is inf


def _reflector_sentence(reflector: Record) -> str:
    known = {int(kind): kind.name.replace("_", " ") for kind in TargetType}
    kind = known.get(reflector.integer("target_type"), "of a kind unknown here")
    return (
        f"The tracker measures the reflector {reflector.text('reflector_name')} ({kind}, surface offset"
        f" {reflector.number('surface_offset'):.3f} mm)."
    )


def _checked_distance_mm(point_mm: Vector) -> float:
    distance_mm = math.hypot(*point_mm)
    if not (math.isfinite(distance_mm) and distance_mm > 0.0):
        raise ConfigurationError(f"the tracker cannot point at {point_mm}: give a point away from its centre")
    return distance_mm


def _names(stored: dict[str, Record]) -> str:
    return ", ".join(sorted(stored)) or "none at all"


def _open(options: Options, clock: Clock) -> LaserTracker:
    link = tcp_link(options, DEFAULT_PORT)
    return LaserTracker(link, clock, reflector=option.text(options, "reflector"))


_OPTIONS = {
    "host": "address of the tracker controller, often 192.168.0.1",
    "port": f"TCP port, default {DEFAULT_PORT}",
    "reflector": "name of the reflector as stored in the tracker; default: the one set in the tracker",
}
PLUGIN = DriverPlugin("leica_emscon", "tracker", "emscon", _OPTIONS, _open)
