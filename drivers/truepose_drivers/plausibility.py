"""What a driver says, held against what is possible: its readings, its count of them, its abilities.

Pure functions on one reading each, which raise ImplausibleReadingError. What takes knowledge of the cell (the
range of this bar, the joints of this robot) is judged where the service takes readings in.

Abilities are looked up by name, as a Python that calls the member would: a runtime protocol sees nothing that
a driver passes on with `__getattr__`.
"""

import math
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final, TypeAlias

from truepose_drivers import api
from truepose_drivers.errors import ImplausibleReadingError, RemoteProtocolError

_FARTHEST_POINT_MM: Final = 200_000.0  # no tracker measures as far
_UNIT_QUATERNION: Final = 1e-6  # how far off a length of one may be
_MOST_TURNED_RAD: Final = 20.0 * math.pi  # ten turns: no joint of an arm is wound up further
_LONGEST_TRAVEL_MM: Final = 1_000.0  # of any gauge
_COLDEST_C, _HOTTEST_C = -100.0, 200.0  # of air and of instruments that still work
_LONGEST_UPTIME_S: Final = 1e10  # three centuries
_SIGNALS: Final = ("good", "out_of_range", "none")
_LONGEST_NAME: Final = 200
_LONGEST_SENTENCE: Final = 2000


def require_point(reading: api.TrackerReading) -> None:
    """Judge a tracker's reading."""
    _require_place(reading.point_mm)
    spreads_mm = (*reading.standard_deviation_mm, reading.rms_mm)  # NaN where the instrument states none
    _require(
        not any(value < 0.0 or math.isinf(value) for value in spreads_mm),
        f"standard deviations of {reading.standard_deviation_mm} mm and a scatter of {reading.rms_mm} mm",
    )
    _require(reading.samples >= 1, f"a mean of {reading.samples} samples")
    _require_duration(reading.duration_s)
    _require(reading.face in (1, 2), f"face {reading.face}")
    if reading.covariance_mm2 is not None:
        _require(_is_covariance(reading.covariance_mm2), f"the covariance {reading.covariance_mm2} mm2")


def require_pose(reading: api.PoseReading) -> None:
    """Judge a reading of position and orientation."""
    _require_place(reading.position_mm)
    length = math.hypot(*reading.quaternion)
    _require(abs(length - 1.0) <= _UNIT_QUATERNION, f"a quaternion of length {length:.6g}")  # a NaN is none
    spreads = (*reading.position_deviation_mm, reading.rotation_deviation_rad, reading.rms_mm)
    _require(
        not any(value < 0.0 or math.isinf(value) for value in spreads),  # NaN where there is one frame only
        f"standard deviations of {reading.position_deviation_mm} mm and {reading.rotation_deviation_rad} rad"
        f" and a scatter of {reading.rms_mm} mm",
    )
    _require(reading.frames >= 1, f"a mean of {reading.frames} frames")
    _require_duration(reading.duration_s)


def require_joints(reading: api.JointReading, joints_before: int | None) -> None:
    """Judge a robot's statement of its joints; `joints_before` is how many it stated last."""
    angles = reading.joints_rad
    _require(len(angles) > 0, "an arm without joints")
    _require(
        joints_before in (None, len(angles)), f"{len(angles)} joints, where it had {joints_before} before"
    )
    _require(_all_finite(angles), f"joints at {angles} rad")
    worst = max(range(len(angles)), key=lambda joint: abs(angles[joint]))
    _require(
        abs(angles[worst]) <= _MOST_TURNED_RAD,
        f"joint {worst + 1} at {math.degrees(angles[worst]):.6g} deg, more than ten turns",
    )
    _require(
        math.isfinite(reading.resolution_rad) and reading.resolution_rad >= 0.0,
        f"a resolution of {reading.resolution_rad} rad",
    )


def require_length(reading: api.BallbarReading) -> None:
    """Judge a reading of a ballbar or a gauge."""
    _require(reading.signal in _SIGNALS, f"the signal {reading.signal!r}")
    # Without a signal the deviation is NaN by agreement (see `BallbarReading`).
    if reading.signal != "none":
        _require(
            abs(reading.deviation_mm) <= _LONGEST_TRAVEL_MM,  # a NaN is not
            f"a deviation of {reading.deviation_mm:.6g} mm, farther than any gauge travels",
        )
    _require(
        math.isfinite(reading.resolution_mm) and reading.resolution_mm > 0.0,
        f"a resolution of {reading.resolution_mm} mm",
    )
    if reading.temperature_c is not None:
        _require_temperature(reading.temperature_c)


def require_some(readings: Sequence[api.BallbarReading]) -> None:
    """Judge how many gauges a box has."""
    _require(len(readings) > 0, "that it has no gauge")


def require_environment(air: api.Environment) -> None:
    """Judge what a weather station says; NaN stands for what it does not measure."""
    _require_temperature(air.temperature_c)
    _require(
        not math.isinf(air.pressure_hpa) and not math.isinf(air.humidity_percent),
        f"a pressure of {air.pressure_hpa} hPa and a humidity of {air.humidity_percent} %",
    )


def require_time(time_s: float, before_s: float | None) -> None:
    """Judge a time stamp against the one before it, which it may equal."""
    _require(0.0 <= time_s <= _LONGEST_UPTIME_S, f"the time {time_s} s")  # a NaN is not
    _require(before_s is None or time_s >= before_s, f"the time {time_s} s after {before_s} s")


def readable(identity: api.DeviceIdentity) -> api.DeviceIdentity:
    """Return an identity in characters that a person can see and a database can keep."""
    return api.DeviceIdentity(
        _visible(identity.manufacturer),
        _visible(identity.model),
        _visible(identity.serial),
        _visible(identity.firmware),
    )


def readable_sentence(text: str) -> str:
    """Return what a driver says in characters as `readable`; empty stays empty."""
    return _printable(text[:_LONGEST_SENTENCE])


def place_or_none(point_mm: api.Vector | None) -> api.Vector | None:
    """Return a place that people look at; one where no reflector can be counts as none, and is no fault."""
    if point_mm is None:
        return None
    x, y, z = map(float, point_mm)
    return (x, y, z) if math.hypot(x, y, z) <= _FARTHEST_POINT_MM else None  # a NaN is not


def _visible(text: str) -> str:
    return _printable(text[:_LONGEST_NAME]) or "unknown"


def _printable(text: str) -> str:
    return "".join(character if character.isprintable() else "?" for character in text).strip()


def _require_place(point_mm: api.Vector) -> None:
    _require(_all_finite(point_mm), f"a point at {point_mm} mm")
    distance_mm = math.hypot(*point_mm)
    _require(
        distance_mm <= _FARTHEST_POINT_MM,
        f"a point {distance_mm / 1000.0:.3g} m away, farther than any tracker measures",
    )


def _require_duration(duration_s: float) -> None:
    _require(math.isfinite(duration_s) and duration_s > 0.0, f"a measurement that took {duration_s} s")


def _require_temperature(temperature_c: float) -> None:
    plausible = math.isnan(temperature_c) or _COLDEST_C <= temperature_c <= _HOTTEST_C
    _require(plausible, f"a temperature of {temperature_c:.6g} °C")


def _is_covariance(matrix: Sequence[Sequence[float]]) -> bool:
    return (
        len(matrix) == 3
        and all(len(row) == 3 and _all_finite(row) for row in matrix)
        and all(matrix[axis][axis] >= 0.0 for axis in range(3))
        and all(
            # Each 2x2 minor, with room for rounding: a correlation beyond one is what a covariance cannot
            # have. Trackers state far better along the beam than across, so that determinants would compare
            # rounding with rounding.
            matrix[i][j] * matrix[i][j] <= matrix[i][i] * matrix[j][j] * (1.0 + 1e-9)
            and math.isclose(matrix[i][j], matrix[j][i], rel_tol=1e-9, abs_tol=1e-300)
            for i, j in ((0, 1), (0, 2), (1, 2))
        )
    )


def _all_finite(values: Sequence[float]) -> bool:
    return all(map(math.isfinite, values))


def _require(plausible: bool, what: str) -> None:
    if not plausible:
        raise ImplausibleReadingError(
            f"it reports {what}, which is not a plausible reading: check its settings and its cable, then"
            " connect again"
        )


# Bars count at least some times a second at rest; a USB stack that hangs repeats its last report for ever.
_LONGEST_S: Final = 1.0  # cell time; whoever asks faster than the device measures hears one reading twice


class StandingCount:
    """Compares each reading of a connection with those before it."""

    def __init__(self) -> None:
        self._sequence: int | None = None
        self._since_s = 0.0

    def require_going_on(self, reading: api.BallbarReading) -> None:
        """Raise RemoteProtocolError for a count that has stood still for longer than a second."""
        if reading.sequence is None or reading.sequence != self._sequence:
            self._sequence, self._since_s = reading.sequence, reading.time_s
        elif reading.time_s - self._since_s > _LONGEST_S:
            raise RemoteProtocolError(
                f"the device has repeated its reading {reading.sequence} for"
                f" {reading.time_s - self._since_s:.1f} s and no longer responds; unplug it and plug it in"
                " again"
            )


ABILITIES: Final[Mapping[api.DeviceKind, tuple[type, ...]]] = {
    "tracker": (api.StatesSettings, api.ShowsReflector),
    "pose_tracker": (api.StatesSettings,),
    "robot": (api.GuardsMotion,),
    "linear_gauge": (api.ReadsChannels,),
}
_Joints: TypeAlias = tuple[float, ...]
AskReflector: TypeAlias = Callable[[], Awaitable[api.Vector | None]]


def motion_guard_of(driver: object) -> api.MotionGuard:
    """Return what a robot's driver says of its motions; where it says nothing or nonsense, the worst."""
    stated = _stated(driver, "motion_guard")
    # A driver that says 0 s or a text here must not make motions seem safer than they are.
    plausible = (
        isinstance(stated, api.MotionGuard)
        and all(
            seconds is None or (_is_number(seconds) and 0.0 < seconds < math.inf)
            for seconds in (stated.stops_unheard_s, stated.longest_piece_s)
        )
        and (
            stated.speed_share is None or (_is_number(stated.speed_share) and 0.0 < stated.speed_share <= 1.0)
        )
        and _is_place(stated.speed_point_mm)
    )
    if not (isinstance(stated, api.MotionGuard) and plausible):
        return api.MotionGuard()
    takes_s = stated.takes_s
    return stated if takes_s is None else replace(stated, takes_s=partial(_time_s, takes_s))


def _time_s(takes_s: Callable[[_Joints, _Joints], float], start_rad: _Joints, target_rad: _Joints) -> float:
    """Return how long a driver says that a motion takes [s]; where it cannot tell, 0, which shortens none."""
    try:
        seconds = float(takes_s(start_rad, target_rad))
    except Exception:
        return 0.0
    return seconds if 0.0 < seconds < math.inf else 0.0


def settings_of(driver: object) -> str:
    """Return what an instrument's driver says that it measures with; empty where it cannot tell."""
    stated = _stated(driver, "settings")
    return readable_sentence(stated) if isinstance(stated, str) else ""


def reflector_of(driver: object) -> AskReflector | None:
    """Return what asks a tracker's driver for the reflector, None where it does not offer that."""
    # By name, not by isinstance: since Python 3.12 a runtime protocol does not see members of `__getattr__`.
    return getattr(driver, "reflector_now", None)


async def channels_of(driver: api.LinearGauge) -> tuple[api.BallbarReading, ...]:
    """Return what all gauges of a box show; of a driver that knows no box, what its one gauge does."""
    read_channels = getattr(driver, "read_channels", None)
    return (await driver.read(),) if read_channels is None else await read_channels()


def _stated(driver: object, name: str) -> Any:
    try:
        return getattr(driver, name, None)
    except Exception:  # whatever foreign code does in a property
        return None


def _is_place(value: object) -> bool:
    if not (isinstance(value, tuple) and len(value) == 3 and all(map(_is_number, value))):
        return False
    return math.hypot(*value) <= _FARTHEST_POINT_MM  # a NaN is not


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
