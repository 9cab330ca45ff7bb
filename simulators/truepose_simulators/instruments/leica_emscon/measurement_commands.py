"""Commands that measure: points, the tilt sensor, the prism where it is."""

from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.protocol.equipment import NivelStatus
from truepose_drivers.leica_emscon.protocol.settings import LengthUnit, MeasMode
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import BeamError
from truepose_simulators.faults.kinds import (
    BeamBroken,
    TrackerCut,
    TrackerRepeatsResult,
    TrackerSilent,
    TrackerStaleResult,
    TrackerUnitsChanged,
)
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity
from truepose_simulators.instruments.leica_emscon.head_commands import (
    NO_REFLECTOR,
    initialised_only,
)
from truepose_simulators.instruments.leica_emscon.parameters import MODE, STATIONARY, UNITS
from truepose_simulators.instruments.leica_emscon.probe import Poses
from truepose_simulators.instruments.leica_emscon.results import (
    Continuous,
    Points,
    air_members,
    coordinates,
)
from truepose_simulators.instruments.leica_emscon.settings import (
    CutShort,
    Handler,
    ServerSettings,
    Steps,
    Wait,
)

_NIVEL_S = 2.0
_PRISM_S = 0.02  # one sample


class Shooting:
    """The distance meter and the sensors behind the protocol."""

    def __init__(self, cell: Cell, settings: ServerSettings, poses: Poses | None) -> None:
        self._cell = cell
        self._tracker = cell.tracker
        self._settings = settings
        self._points = Points(cell.tracker, settings)
        self._poses = poses
        self._continuous = Continuous(cell, settings)
        self._last_result: protocol.Result | None = None

    def handlers(self) -> dict[int, Handler]:
        """Return the commands served here."""
        served: dict[int, Handler] = {
            protocol.Command.START_MEASUREMENT: self._start,
            protocol.Command.START_NIVEL_MEASUREMENT: self._start_nivel,
            protocol.Command.GET_CURRENT_PRISM_POSITION: self._prism,
            protocol.Command.CALL_ORIENT_TO_GRAVITY: self._orient_to_gravity,
        }
        return {command: initialised_only(self._cell, handler) for command, handler in served.items()}

    def stationary(self, command: int) -> Steps:
        """Measure what the mode says: the answer at once, the value after the measuring time."""
        subject = self._subject()
        try:
            before = subject.sight()
        except BeamError:
            yield protocol.Answer(command, NO_REFLECTOR)
            return
        if (self._tracker.target or "").startswith("tool"):
            self._cell.measured_here()
        fault = self._cell.faults.next_reading()
        # Before the answer: a result that was under way when somebody asked, which must not be taken for
        # theirs.
        if isinstance(fault, TrackerStaleResult) and self._last_result is not None:
            yield self._last_result
        yield protocol.Answer(command)
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_BUSY)
        if isinstance(fault, TrackerSilent):
            return
        if isinstance(fault, TrackerUnitsChanged):
            inches = protocol.Record(self._settings.kept(UNITS), len_unit_type=LengthUnit.INCH)
            self._settings.keep(UNITS, inches)
            yield protocol.StatusChange(UNITS.event)
        duration_s = self._settings.kept(STATIONARY).integer("meas_time") / 1000.0
        yield Wait(duration_s)
        try:
            if isinstance(fault, BeamBroken):
                subject.lose()
            packet = subject.result(duration_s, before, self.air())
        except BeamError:
            yield protocol.ErrorReport(command, NO_REFLECTOR)
            yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_NOT_READY)
            return
        if isinstance(fault, TrackerRepeatsResult) and self._last_result is not None:
            packet = self._last_result
        self._last_result = packet
        yield CutShort(packet) if isinstance(fault, TrackerCut) else packet
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_READY)

    def air(self) -> protocol.Record:
        """Return what the weather station says now."""
        temperature_c = self._cell.air.sensed_c(self._cell.clock.now_s, self._cell.noise)
        return air_members(self._settings, temperature_c)

    def reflector_position(self) -> protocol.Result | None:
        """Return the packet of the position stream, None when nothing is locked on."""
        try:
            members = coordinates(self._settings, self._subject().position(_PRISM_S))
        except BeamError:
            return None
        return protocol.Result(protocol.PacketType.REFLECTOR_POS_RESULT, members)

    def _subject(self) -> Points | Poses:
        measures_poses = self._settings.kept(MODE)["meas_mode"] == MeasMode.STATIONARY_6D
        return self._poses if measures_poses and self._poses is not None else self._points

    def _start(self, request: protocol.Request) -> Steps:
        if self._settings.kept(MODE)["meas_mode"] == MeasMode.CONTINUOUS_TIME:
            return self._continuous.measure(request.command)
        return self.stationary(request.command)

    def _start_nivel(self, request: protocol.Request) -> Steps:
        """Read the tilt; the plain answer never comes, the result packet stands for it."""
        del request
        yield Wait(_NIVEL_S)
        x_rad, y_rad = self._tracker.tilt_rad
        to_wire = self._settings.units.to_wire
        temperature_c = self._cell.air.sensed_c(self._cell.clock.now_s, self._cell.noise)
        members = protocol.Record(
            nivel_status=NivelStatus.ALL_OK,
            x_tilt=to_wire(Quantity.ANGLE, x_rad),
            y_tilt=to_wire(Quantity.ANGLE, y_rad),
            nivel_temperature=to_wire(Quantity.TEMPERATURE, temperature_c),
        )
        yield protocol.Result(protocol.PacketType.NIVEL_RESULT, members)

    def _orient_to_gravity(self, request: protocol.Request) -> Steps:
        yield Wait(4 * _NIVEL_S)
        omega, phi = (self._settings.units.to_wire(Quantity.ANGLE, tilt) for tilt in self._tracker.tilt_rad)
        yield protocol.Answer(request.command, values=protocol.Record(omega=omega, phi=phi))

    def _prism(self, request: protocol.Request) -> Steps:
        position = self.reflector_position()
        if position is None:
            yield protocol.Answer(request.command, NO_REFLECTOR)
        else:
            yield protocol.Answer(request.command, values=position.values)
