"""What an emScon client can set and ask back: one row per pair of commands.

Values are kept in inside units, so that asking after a change of units gives the same quantity.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum

from truepose_drivers.leica_emscon.protocol import (
    Command,
    Record,
    ResultStatus,
    SystemStatusChange,
    Value,
    settings,
)
from truepose_simulators.cell.environment import HUMIDITY_PERCENT, PRESSURE_HPA
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity

Check = Callable[[Value], bool]


def _is(kind: type[IntEnum]) -> Check:
    return lambda value: isinstance(value, kind)


def _between(low: float, high: float) -> Check:
    return lambda value: not isinstance(value, str) and low <= value <= high


_POSITIVE = _between(1e-12, math.inf)
_COORDINATES: Mapping[str, Quantity] = {f"val{i}": Quantity.LENGTH for i in (1, 2, 3)}
_ANGLES: Mapping[str, Quantity] = {f"rot{i}": Quantity.ANGLE for i in (1, 2, 3)}


@dataclass(frozen=True, slots=True)
class Parameter:
    """A pair of Set and Get commands with its members."""

    setter: Command
    getter: Command
    event: SystemStatusChange
    defaults: Mapping[str, Value]  # inside units
    quantities: Mapping[str, Quantity]  # members that are not listed are plain numbers
    checks: Mapping[str, Check]

    def fault(self, values: Record) -> int:
        """Return the status that a bad member earns by its position, 0 when all are good."""
        for position, (name, value) in enumerate(values.items(), start=1):
            check = self.checks.get(name)
            if check is not None and not check(value):
                return wrong_parameter(position)
        return ResultStatus.ALL_OK


def not_finite(values: Record) -> int:
    """Return the status of the first member that is no finite number, 0 when there is none."""
    for position, value in enumerate(values.values(), start=1):
        if isinstance(value, float) and not math.isfinite(value):
            return wrong_parameter(position)
    return ResultStatus.ALL_OK


def wrong_parameter(position: int) -> int:
    """Return the status WrongParameter<position>; they have two ranges of numbers."""
    if position <= 7:
        return ResultStatus.WRONG_PARAMETER_1 + position - 1
    return ResultStatus.WRONG_PARAMETER_8 + position - 8


def _parameter(
    name: str,
    defaults: Mapping[str, Value],
    quantities: Mapping[str, Quantity] | None = None,
    checks: Mapping[str, Check] | None = None,
) -> Parameter:
    """Return what can be set by SET_`name`; a member with a numbered default takes numbers of its kind."""
    numbered = {
        member: _is(type(default)) for member, default in defaults.items() if isinstance(default, IntEnum)
    }
    return Parameter(
        Command[f"SET_{name}"],
        Command[f"GET_{name}"],
        SystemStatusChange[f"{name}_CHANGED"],
        defaults,
        quantities or {},
        numbered | dict(checks or {}),
    )


UNITS = _parameter(
    "UNITS",
    {
        "len_unit_type": settings.LengthUnit.METER,
        "ang_unit_type": settings.AngleUnit.RADIAN,
        "temp_unit_type": settings.TemperatureUnit.CELSIUS,
        "press_unit_type": settings.PressureUnit.MBAR,
        "hum_unit_type": settings.HumidityUnit.RELATIVE,
    },
)
STATION = _parameter(
    "STATION_ORIENTATION_PARAMS",
    dict.fromkeys(("val1", "val2", "val3", "rot1", "rot2", "rot3"), 0.0),
    {**_COORDINATES, **_ANGLES},
)
TRANSFORMATION = _parameter(
    "TRANSFORMATION_PARAMS",
    {**dict.fromkeys(("val1", "val2", "val3", "rot1", "rot2", "rot3"), 0.0), "scale": 1.0},
    {**_COORDINATES, **_ANGLES},
    {"scale": _POSITIVE},
)
ENVIRONMENT = _parameter(
    "ENVIRONMENT_PARAMS",
    {"temperature": 20.0, "pressure": PRESSURE_HPA, "humidity": HUMIDITY_PERCENT},
    {"temperature": Quantity.TEMPERATURE, "pressure": Quantity.PRESSURE},
    {"humidity": _between(0.0, 100.0)},
)
REFRACTION = _parameter(
    "REFRACTION_PARAMS",
    {"ifm_refraction_index": 1.000271, "adm_refraction_index": 1.000274},
    checks={"ifm_refraction_index": _POSITIVE, "adm_refraction_index": _POSITIVE},
)
MODE = _parameter(
    "MEASUREMENT_MODE",
    {"meas_mode": settings.MeasMode.STATIONARY},
)
COORDINATES = _parameter(
    "COORDINATE_SYSTEM_TYPE",
    {"coord_sys_type": settings.CoordinateSystemType.RHR},
)
STATIONARY = _parameter(
    "STATIONARY_MODE_PARAMS",
    {"meas_time": 1000, "use_adm": True},
    # The header allows 500 ms to 100 s on older trackers; an AT40x starts lower.
    checks={"meas_time": _between(100, 100_000)},
)
# Of an AT901 alone. Regions are not modelled.
CONTINUOUS_TIME = _parameter(
    "CONTINUOUS_TIME_MODE_PARAMS",
    {
        "time_separation": 500,
        "number_of_points": 0,
        "use_region": False,
        "region_type": settings.RegionType.SPHERE,
    },
    checks={
        "time_separation": _between(1, 100_000),
        "number_of_points": _between(0, 2**31 - 1),
        "use_region": lambda value: not value,
    },
)
REFLECTOR = _parameter("REFLECTOR", {"internal_reflector_id": 1})
SEARCH = _parameter(
    "SEARCH_PARAMS",
    {"search_radius": 50.0, "time_out": 10_000},
    {"search_radius": Quantity.LENGTH},
    {"search_radius": _POSITIVE, "time_out": _between(1, 1_000_000)},
)
ADM = _parameter(
    "ADM_PARAMS",
    {"target_stability_tolerance": 0.005, "retry_time_frame": 500, "number_of_retrys": 3},
    {"target_stability_tolerance": Quantity.LENGTH},
    {"target_stability_tolerance": _POSITIVE},
)
SETTINGS = _parameter(
    "SYSTEM_SETTINGS",
    {
        "weather_monitor_status": settings.WeatherMonitorStatus.READ_AND_CALCULATE_REFRACTIONS,
        "apply_transformation_params": False,
        "apply_station_orientation_params": False,
        "keep_last_position": True,
        # Off until asked for: a client that reads one packet per request is not surprised.
        "send_unsolicited_messages": False,
        "send_reflector_position_data": False,
        "try_measurement_mode": False,
        "has_nivel": True,
        "has_video_camera": False,
    },
)
STATISTIC = _parameter(
    "STATISTIC_MODE",
    {
        "stationary_measurements": settings.StatisticMode.STANDARD,
        "continuous_measurements": settings.StatisticMode.STANDARD,
    },
)
COMPENSATION = _parameter("COMPENSATION", {"internal_compensation_id": 1})

PARAMETERS = (
    UNITS, STATION, TRANSFORMATION, ENVIRONMENT, REFRACTION, MODE, COORDINATES, STATIONARY, CONTINUOUS_TIME,
    REFLECTOR, SEARCH, ADM, SETTINGS, STATISTIC, COMPENSATION,
)  # fmt: skip
