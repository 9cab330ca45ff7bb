"""What an answer with measured numbers means as a reading; pure."""

import math
from collections.abc import Mapping
from typing import Literal, cast

from truepose_drivers.api import Environment, PoseReading, Quaternion, TrackerReading, Vector
from truepose_drivers.json_bridge.protocol import BridgeError, number, numbers

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
        quaternion=cast(Quaternion, numbers(values, "quaternion", 4)),
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
        number(values, "temperature_c"),
        _optional(values, "pressure_hpa"),
        _optional(values, "humidity_percent"),
    )


def _vector(values: Values, key: str) -> Vector:
    return cast(Vector, numbers(values, key, 3))


def _stated(values: Values, key: str) -> Vector:
    return _NOT_STATED if values.get(key) is None else _vector(values, key)


def _optional(values: Values, key: str) -> float:
    return math.nan if values.get(key) is None else number(values, key)


def _scatter_mm(values: Values) -> float:
    """Return the total scatter, from the deviations where it is not stated; one of them must be."""
    if values.get("rms_mm") is None and values.get("deviation_mm") is None:
        raise BridgeError("neither rms_mm nor deviation_mm is given: how much did the samples scatter?")
    if values.get("rms_mm") is None:
        return math.hypot(*_vector(values, "deviation_mm"))
    return number(values, "rms_mm")


def _whole(values: Values, key: str) -> int:
    """Return how many were averaged, one where nothing is said."""
    count = values.get(key, 1)
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count < 2**31:
        raise BridgeError(f"{key} is {repr(count)[:40]}; a whole number from 1 was expected")
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
    raise BridgeError(f"face is {values['face']!r:.40}; 1 or 2 was expected")


def _covariance(values: Values) -> tuple[Vector, Vector, Vector] | None:
    """Return xx, yy, zz, xy, xz, yz as a matrix, None where they are not given."""
    if values.get("covariance_mm2") is None:
        return None
    xx, yy, zz, xy, xz, yz = numbers(values, "covariance_mm2", 6)
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
