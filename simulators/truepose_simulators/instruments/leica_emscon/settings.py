"""The settings of one emScon server, which outlive connections, and the steps that a command has it take."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from truepose_drivers.leica_emscon.protocol import (
    Command,
    FromServer,
    Record,
    Request,
    ResultStatus,
    settings,
)
from truepose_simulators.instruments.leica_emscon.coordinates import CoordinateView, Quantity, Units
from truepose_simulators.instruments.leica_emscon.parameters import (
    COORDINATES,
    PARAMETERS,
    SETTINGS,
    STATION,
    STATISTIC,
    TRANSFORMATION,
    UNITS,
    Parameter,
    wrong_parameter,
)
from truepose_simulators.physics.rigid import FloatArray, inverse, pose_matrix


@dataclass(frozen=True, slots=True)
class Wait:
    """The head is at work for that long."""

    duration_s: float
    stoppable: bool = False  # takes wall time at any pace: only a client's request ends what waits so


@dataclass(frozen=True, slots=True)
class CutShort:
    """The link breaks in the middle of this packet."""

    packet: FromServer


@dataclass(frozen=True, slots=True)
class HangUp:
    """The server closes the connection."""


Step: TypeAlias = FromServer | Wait | CutShort | HangUp
Steps: TypeAlias = Iterator[Step]
Handler: TypeAlias = Callable[[Request], Steps]


_EXTERNAL_POWER = 110
_READ_ONLY = (
    settings.SystemParameter.POWER_LOCK_FUNCTION_AVAILABLE,
    settings.SystemParameter.AT4XX_CONTROLLER_BATTERY_STATUS,
    settings.SystemParameter.AT4XX_SENSOR_BATTERY_STATUS,
)


class ServerSettings:
    """Everything that a client has set, in inside units."""

    def __init__(self) -> None:
        self.restore_start()

    def restore_start(self) -> None:
        """Take the values of power-up."""
        self._kept: dict[Command, Record] = {
            parameter.setter: Record(parameter.defaults) for parameter in PARAMETERS
        }
        self.long_parameters: dict[int, int] = {
            settings.SystemParameter.KEEP_LAST_POSITION_FLAG: 1,
            settings.SystemParameter.WEATHER_MONITOR_SETTING: 2,
            settings.SystemParameter.DISPLAY_REFLECTOR_POSITION: 0,
            settings.SystemParameter.TCP_COMMAND_QUEUE_SIZE: 0,
            settings.SystemParameter.TCP_DATA_PACKET_RATE: 3,
            settings.SystemParameter.POWER_LOCK_FUNCTION_AVAILABLE: 1,
            settings.SystemParameter.POWER_LOCK_FUNCTION_ACTIVE: 1,
            settings.SystemParameter.AT4XX_CONTROLLER_BATTERY_STATUS: _EXTERNAL_POWER,
            settings.SystemParameter.AT4XX_SENSOR_BATTERY_STATUS: _EXTERNAL_POWER,
            settings.SystemParameter.AT4XX_INCLINATION_SENSOR_STATE: 0,
        }
        self.double_parameters: dict[int, float] = {
            settings.SystemParameter.D_TEMPERATURE_THRESHOLD: 0.5,
            settings.SystemParameter.D_PRESSURE_THRESHOLD: 1.0,
            settings.SystemParameter.D_HUMIDITY_THRESHOLD: 5.0,
        }
        self._view: CoordinateView | None = None

    def keep(self, parameter: Parameter, values: Record) -> None:
        """Store checked members of a Set request."""
        units = self.units
        inside = {
            name: value if quantity is Quantity.NUMBER else units.from_wire(quantity, values.number(name))
            for name, value in values.items()
            for quantity in [parameter.quantities.get(name, Quantity.NUMBER)]
        }
        self._kept[parameter.setter] = Record(inside)
        self._view = None

    def show(self, parameter: Parameter) -> Record:
        """Return the members of a Get answer, in the user's units."""
        kept = self._kept[parameter.setter]
        units = self.units
        return Record({
            name: value if quantity is Quantity.NUMBER else units.to_wire(quantity, kept.number(name))
            for name, value in kept.items()
            for quantity in [parameter.quantities.get(name, Quantity.NUMBER)]
        })

    @property
    def weather_station_read(self) -> bool:
        """Whether the sensors count, not what the user has set."""
        return (
            self._kept[SETTINGS.setter]["weather_monitor_status"]
            != settings.WeatherMonitorStatus.NOT_CONNECTED
        )

    def set_long_parameter(self, number: int, value: int) -> int:
        """Store a system parameter; returns the status."""
        if number not in self.long_parameters or number in _READ_ONLY:
            return wrong_parameter(1)
        if number == settings.SystemParameter.TCP_COMMAND_QUEUE_SIZE and not 0 <= value <= 10:
            return wrong_parameter(2)
        if number == settings.SystemParameter.TCP_DATA_PACKET_RATE and not 3 <= value <= 10:
            return wrong_parameter(2)
        self.long_parameters[number] = value
        return ResultStatus.ALL_OK

    def set_double_parameter(self, number: int, value: float) -> int:
        """Store a system parameter; returns the status."""
        if number not in self.double_parameters:
            return wrong_parameter(1)
        if not math.isfinite(value) or value < 0.0:
            return wrong_parameter(2)
        self.double_parameters[number] = value
        return ResultStatus.ALL_OK

    def kept(self, parameter: Parameter) -> Record:
        """Return stored members in inside units."""
        return self._kept[parameter.setter]

    def flag(self, name: str) -> bool:
        """Return one of the system settings."""
        return bool(self._kept[SETTINGS.setter][name])

    @property
    def units(self) -> Units:
        """Units in force."""
        return self.view.units

    @property
    def extended_statistics(self) -> bool:
        """Whether stationary measurements are answered with the longer packet."""
        return self._kept[STATISTIC.setter]["stationary_measurements"] == settings.StatisticMode.EXTENDED

    @property
    def extended_statistics_of_streams(self) -> bool:
        """Whether continuous measurements come as the longer packet."""
        return self._kept[STATISTIC.setter]["continuous_measurements"] == settings.StatisticMode.EXTENDED

    @property
    def view(self) -> CoordinateView:
        """How coordinates are to be shown."""
        if self._view is None:
            kind = settings.CoordinateSystemType(self._kept[COORDINATES.setter].integer("coord_sys_type"))
            scale = 1.0
            placement = np.eye(4)
            if self.flag("apply_station_orientation_params"):
                placement = self._placement(STATION)
            if self.flag("apply_transformation_params"):
                placement = inverse(self._placement(TRANSFORMATION)) @ placement
                scale = self._kept[TRANSFORMATION.setter].number("scale")
            self._view = CoordinateView(self._units(), kind, placement, scale)
        return self._view

    def _units(self) -> Units:
        kept = self._kept[UNITS.setter]
        return Units(
            settings.LengthUnit(kept.integer("len_unit_type")),
            settings.AngleUnit(kept.integer("ang_unit_type")),
            settings.TemperatureUnit(kept.integer("temp_unit_type")),
            settings.PressureUnit(kept.integer("press_unit_type")),
        )

    def _placement(self, parameter: Parameter) -> FloatArray:
        kept = self._kept[parameter.setter]
        return pose_matrix(np.array(kept.vector()), np.array(kept.vector("rot1", "rot2", "rot3")))
