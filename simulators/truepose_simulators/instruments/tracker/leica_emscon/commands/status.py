"""Commands that ask in what state the tracker is."""

from collections.abc import Callable

from truepose_drivers.leica_emscon.protocol import Answer, Command, MeasurementStatusInfo, Record, Request
from truepose_drivers.leica_emscon.protocol.equipment import (
    ADMStatus,
    LaserProcessorStatus,
    TrackerFace,
    TrackerProcessorStatus,
    TrackerStatus,
)
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.tracker.leica_emscon.commands.identity import (
    SERVER_VERSION,
    serial_number,
)
from truepose_simulators.instruments.tracker.leica_emscon.parameters import SETTINGS
from truepose_simulators.instruments.tracker.leica_emscon.settings import ServerSettings
from truepose_simulators.instruments.tracker.leica_emscon.steps import Steps
from truepose_simulators.instruments.tracker.leica_emscon.units import Quantity

_PRESENT = (
    MeasurementStatusInfo.TRACKER_FOUND
    | MeasurementStatusInfo.TRACKER_COMPENSATION_FOUND
    | MeasurementStatusInfo.ADM_FOUND
    | MeasurementStatusInfo.ADM_COMPENSATION_FOUND
    | MeasurementStatusInfo.NIVEL_IN_WORKING_RANGE
)


class StatusReports:
    """Answers about the state of the tracker; none of them turns anything."""

    def __init__(self, cell: Cell, settings: ServerSettings, last_status: Callable[[], int]) -> None:
        self._cell = cell
        self._tracker = cell.tracker
        self._settings = settings
        self._last_status = last_status

    def handlers(self) -> dict[int, Callable[[Request], Steps]]:
        """Return the commands served here."""
        return {
            Command.GET_SYSTEM_STATUS: self._system,
            Command.GET_TRACKER_STATUS: self._tracker_status,
            Command.GET_MEASUREMENT_STATUS_INFO: self._measurement,
            Command.GET_FACE: self._face,
            Command.GET_OBJECT_TEMPERATURE: self._object_temperature,
        }

    def _system(self, request: Request) -> Steps:
        ready = self._tracker.initialised
        major, minor, build = SERVER_VERSION
        yield Answer(
            request.command,
            values=Record(
                last_result_status=self._last_status(),
                tracker_processor_status=(
                    TrackerProcessorStatus.INITIALIZED if ready else TrackerProcessorStatus.COMPENSATION_SET
                ),
                laser_status=LaserProcessorStatus.LASER_READY,
                adm_status=ADMStatus.ADM_READY,
                major_version_number=major,
                minor_version_number=minor,
                build_number=build,
                weather_monitor_status=self._settings.kept(SETTINGS)["weather_monitor_status"],
                flags_value=0,  # always, on an AT40x
                tracker_serial_number=serial_number(self._cell),
            ),
        )

    def _tracker_status(self, request: Request) -> Steps:
        locked = self._tracker.initialised and self._tracker.target is not None
        status = TrackerStatus.READY if locked else TrackerStatus.NOT_READY
        yield Answer(request.command, values=Record(tracker_status=status))

    def _measurement(self, request: Request) -> Steps:
        info = _PRESENT
        if self._tracker.initialised:
            info |= MeasurementStatusInfo.INITIALIZED
        if self._tracker.target is not None:
            info |= MeasurementStatusInfo.REFLECTOR_FOUND
        if self._tracker.face == 1:
            info |= MeasurementStatusInfo.IN_FACE_1
        values = Record(last_result_status=self._last_status(), measurement_status_info=int(info))
        yield Answer(request.command, values=values)

    def _face(self, request: Request) -> Steps:
        yield Answer(request.command, values=Record(tracker_face=TrackerFace(self._tracker.face)))

    def _object_temperature(self, request: Request) -> Steps:
        sensed_c = self._cell.air.sensed_c(self._cell.clock.now_s, self._cell.noise)
        shown = self._settings.units.to_wire(Quantity.TEMPERATURE, sensed_c)
        yield Answer(request.command, values=Record(object_temperature=shown))
