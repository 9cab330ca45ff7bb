"""Continuous measurements of the reflector locked on, by time: values in blocks until somebody stops them."""

from dataclasses import dataclass

from truepose_drivers.leica_emscon.protocol import (
    Answer,
    ErrorReport,
    MeasurementStatus,
    PacketType,
    Record,
    Result,
    StatusChange,
    SystemStatusChange,
)
from truepose_drivers.leica_emscon.protocol.settings import MeasMode, SystemParameter
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import BeamError
from truepose_simulators.instruments.tracker.device import PointMeasured
from truepose_simulators.instruments.tracker.leica_emscon.commands.aiming import NO_REFLECTOR
from truepose_simulators.instruments.tracker.leica_emscon.measuring import (
    air_members,
    coordinates,
    covariances,
    deviations,
    total,
)
from truepose_simulators.instruments.tracker.leica_emscon.parameters import CONTINUOUS_TIME
from truepose_simulators.instruments.tracker.leica_emscon.settings import ServerSettings
from truepose_simulators.instruments.tracker.leica_emscon.steps import Steps, Wait

_MICROSECONDS = 1_000_000


@dataclass(frozen=True, slots=True)
class _Course:
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
            yield Answer(command, NO_REFLECTOR)
            return
        yield Answer(command)
        yield StatusChange(SystemStatusChange.MEAS_STATUS_BUSY)
        try:
            yield from self._blocks(self._course())
        except BeamError:
            yield ErrorReport(command, NO_REFLECTOR)
            yield StatusChange(SystemStatusChange.MEAS_STATUS_NOT_READY)
            return
        yield StatusChange(SystemStatusChange.MEASUREMENT_COUNT_REACHED)
        yield StatusChange(SystemStatusChange.MEAS_STATUS_READY)

    def _course(self) -> _Course:
        kept = self._settings.kept(CONTINUOUS_TIME)
        period_s = kept.integer("time_separation") / 1000.0
        packets_per_s = self._settings.long_parameters[SystemParameter.TCP_DATA_PACKET_RATE]
        block = max(1, round(1.0 / (packets_per_s * period_s)))
        return _Course(period_s, kept.integer("number_of_points"), block)

    def _blocks(self, course: _Course) -> Steps:
        started_s, measured = self._cell.clock.now_s, 0
        elements: list[Record] = []
        while not (measured and course.ends_at(measured)):
            yield Wait(course.period_s, stoppable=True)
            elements.append(self._element(self._cell.clock.now_s - started_s, course.period_s))
            measured += 1
            if course.fills_a_packet(measured):
                yield self._packet(tuple(elements))
                elements.clear()

    def _element(self, elapsed_s: float, period_s: float) -> Record:
        """Measure once; raises BeamError."""
        point = self._cell.tracker.measure(period_s)
        seconds, microseconds = divmod(round(elapsed_s * _MICROSECONDS), _MICROSECONDS)
        members = coordinates(self._settings, point.position_mm)
        members.update(status=MeasurementStatus.ALL_OK, time1=seconds, time2=microseconds)
        if self._settings.extended_statistics_of_streams:
            members.update(self._apriori(point))
        return members

    def _apriori(self, point: PointMeasured) -> Record:
        shown = self._settings.view.covariance_to_wire(point.position_mm, point.apriori_covariance_mm2)
        return Record(
            {**deviations("apriori_std", shown), **covariances("apriori_covar", shown)},
            apriori_std_total=total(point.apriori_covariance_mm2, self._settings),
        )

    def _packet(self, elements: tuple[Record, ...]) -> Result:
        temperature_c = self._cell.air.sensed_c(self._cell.clock.now_s, self._cell.noise)
        members = air_members(self._settings, temperature_c)
        members.update(meas_mode=MeasMode.CONTINUOUS_TIME, is_try_mode=False)
        extended = self._settings.extended_statistics_of_streams
        kind = PacketType.MULTI_MEAS_RESULT_2 if extended else PacketType.MULTI_MEAS_RESULT
        return Result(kind, members, elements=elements)
