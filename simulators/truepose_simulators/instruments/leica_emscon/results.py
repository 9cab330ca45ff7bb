"""Measurements as result packets: stationary ones, and continuous ones until somebody stops them."""

from dataclasses import dataclass

import numpy as np

from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.protocol.settings import MeasMode, SystemParameter
from truepose_simulators.cell.environment import HUMIDITY_PERCENT, PRESSURE_HPA
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import BeamError
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity
from truepose_simulators.instruments.leica_emscon.head_commands import NO_REFLECTOR
from truepose_simulators.instruments.leica_emscon.parameters import CONTINUOUS_TIME
from truepose_simulators.instruments.leica_emscon.settings import ServerSettings, Steps, Wait
from truepose_simulators.instruments.tracker import PointMeasured, Tracker
from truepose_simulators.physics.rigid import FloatArray


class Points:
    """The reflector locked on, as subject of a measurement."""

    def __init__(self, tracker: Tracker, settings: ServerSettings) -> None:
        self._tracker = tracker
        self._settings = settings

    def sight(self) -> FloatArray:
        """Return where it is now; raises BeamError."""
        return self._tracker.locked_target().position_mm

    def lose(self) -> None:
        """Let go of it."""
        self._tracker.release()

    def result(self, duration_s: float, before_mm: FloatArray, air: protocol.Record) -> protocol.Result:
        """Measure it, where it was at `before_mm` when that began; raises BeamError."""
        point = self._tracker.measure(duration_s, before_mm)
        self._tracker.last_measured_mm = point.position_mm
        return stationary_result(point, air, self._settings)

    def position(self, duration_s: float) -> FloatArray:
        """Return one quick reading of where it is; raises BeamError."""
        return self._tracker.measure(duration_s).position_mm


def stationary_result(
    point: PointMeasured, air: protocol.Record, settings: ServerSettings
) -> protocol.Result:
    """Return the packet that the statistic mode asks for."""
    shown = settings.view.covariance_to_wire(point.position_mm, point.covariance_mm2)
    apriori = settings.view.covariance_to_wire(point.position_mm, point.apriori_covariance_mm2)
    members = protocol.Record(meas_mode=MeasMode.STATIONARY, is_try_mode=False, **air)
    members.update(coordinates(settings, point.position_mm))
    members.update(deviations("std", shown), **deviations("apriori_std", apriori))
    # The total is a length: the root of the sum of the variances in space, whatever the coordinates are.
    members["std_total"] = total(point.covariance_mm2, settings)
    members["apriori_std_total"] = total(point.apriori_covariance_mm2, settings)
    if not settings.extended_statistics:
        members.update(pointing_error1=0.0, pointing_error2=0.0, pointing_error3=0.0)
        return protocol.Result(protocol.PacketType.SINGLE_MEAS_RESULT, members)
    members.update(covariances("covar", shown), **covariances("apriori_covar", apriori))
    members.update(pointing_error_h=0.0, pointing_error_v=0.0, pointing_error_d=0.0)
    return protocol.Result(protocol.PacketType.SINGLE_MEAS_RESULT_2, members)


def coordinates(settings: ServerSettings, position_mm: FloatArray) -> protocol.Record:
    """Return val1 val2 val3 of a point of the instrument frame."""
    return protocol.Record(zip(("val1", "val2", "val3"), settings.view.to_wire(position_mm), strict=True))


def air_members(settings: ServerSettings, temperature_c: float) -> protocol.Record:
    """Return the air as the server states it with a result."""
    to_wire = settings.units.to_wire
    return protocol.Record(
        temperature=to_wire(Quantity.TEMPERATURE, temperature_c),
        pressure=to_wire(Quantity.PRESSURE, PRESSURE_HPA),
        humidity=HUMIDITY_PERCENT,
    )


def deviations(name: str, covariance: FloatArray) -> protocol.Record:
    """Return the standard deviations of three coordinates as members `name`1 to `name`3."""
    deviations = np.sqrt(np.diag(covariance)).tolist()
    return protocol.Record({f"{name}{number}": value for number, value in enumerate(deviations, start=1)})


def covariances(name: str, covariance: FloatArray) -> protocol.Record:
    """Return the covariances of three coordinates as members `name`12, `name`13, `name`23."""
    pairs = {"12": (0, 1), "13": (0, 2), "23": (1, 2)}
    return protocol.Record({f"{name}{key}": float(covariance[pair]) for key, pair in pairs.items()})


def total(covariance_mm2: FloatArray, settings: ServerSettings) -> float:
    """Return the root of the sum of the variances, in the user's unit."""
    return settings.units.to_wire(Quantity.LENGTH, float(np.sqrt(np.trace(covariance_mm2))))


_MICROSECONDS = 1_000_000


@dataclass(frozen=True, slots=True)
class _ContinuousMeasurement:
    """How one continuous measurement goes on."""

    period_s: float
    points: int  # 0: until it is stopped
    block: int  # values per packet

    def ends_at(self, measured: int) -> bool:
        return measured == self.points > 0

    def fills_a_packet(self, measured: int) -> bool:
        return measured % self.block == 0 or self.ends_at(measured)


class Continuous:
    """The tracker as it follows the reflector and measures at even times."""

    def __init__(self, cell: Cell, settings: ServerSettings) -> None:
        self._cell = cell
        self._settings = settings

    def measure(self, command: int) -> Steps:
        """Answer at once, then measure until the count is reached, the beam is lost or somebody stops it."""
        try:
            self._cell.tracker.locked_target()
        except BeamError:
            yield protocol.Answer(command, NO_REFLECTOR)
            return
        yield protocol.Answer(command)
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_BUSY)
        try:
            yield from self._blocks(self._course())
        except BeamError:
            yield protocol.ErrorReport(command, NO_REFLECTOR)
            yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_NOT_READY)
            return
        yield protocol.StatusChange(protocol.SystemStatusChange.MEASUREMENT_COUNT_REACHED)
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_READY)

    def _course(self) -> _ContinuousMeasurement:
        kept = self._settings.kept(CONTINUOUS_TIME)
        period_s = kept.integer("time_separation") / 1000.0
        packets_per_s = self._settings.long_parameters[SystemParameter.TCP_DATA_PACKET_RATE]
        block = max(1, round(1.0 / (packets_per_s * period_s)))
        return _ContinuousMeasurement(period_s, kept.integer("number_of_points"), block)

    def _blocks(self, course: _ContinuousMeasurement) -> Steps:
        started_s, measured = self._cell.clock.now_s, 0
        elements: list[protocol.Record] = []
        while not (measured and course.ends_at(measured)):
            yield Wait(course.period_s, stoppable=True)
            elements.append(self._element(self._cell.clock.now_s - started_s, course.period_s))
            measured += 1
            if course.fills_a_packet(measured):
                yield self._packet(tuple(elements))
                elements.clear()

    def _element(self, elapsed_s: float, period_s: float) -> protocol.Record:
        """Measure once; raises BeamError."""
        point = self._cell.tracker.measure(period_s)
        seconds, microseconds = divmod(round(elapsed_s * _MICROSECONDS), _MICROSECONDS)
        members = coordinates(self._settings, point.position_mm)
        members.update(status=protocol.MeasurementStatus.ALL_OK, time1=seconds, time2=microseconds)
        if self._settings.extended_statistics_of_streams:
            members.update(self._apriori(point))
        return members

    def _apriori(self, point: PointMeasured) -> protocol.Record:
        shown = self._settings.view.covariance_to_wire(point.position_mm, point.apriori_covariance_mm2)
        return protocol.Record(
            {**deviations("apriori_std", shown), **covariances("apriori_covar", shown)},
            apriori_std_total=total(point.apriori_covariance_mm2, self._settings),
        )

    def _packet(self, elements: tuple[protocol.Record, ...]) -> protocol.Result:
        temperature_c = self._cell.air.sensed_c(self._cell.clock.now_s, self._cell.noise)
        members = air_members(self._settings, temperature_c)
        members.update(meas_mode=MeasMode.CONTINUOUS_TIME, is_try_mode=False)
        extended = self._settings.extended_statistics_of_streams
        kind = protocol.PacketType.MULTI_MEAS_RESULT_2 if extended else protocol.PacketType.MULTI_MEAS_RESULT
        return protocol.Result(kind, members, elements=elements)
