"""Commands that ask what the tracker is, and in what state."""

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

from truepose_drivers.leica_emscon.protocol import (
    Answer,
    Command,
    MeasurementStatusInfo,
    Record,
    Request,
    equipment,
)
from truepose_drivers.leica_emscon.protocol.command_members import EXCHANGES
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity
from truepose_simulators.instruments.leica_emscon.parameters import SETTINGS
from truepose_simulators.instruments.leica_emscon.settings import Handler, ServerSettings, Steps

_Members: TypeAlias = Mapping[str, int | float | str]

SERVER_VERSION = (3, 6, 412)  # emScon server: major, minor, build
_FIRMWARE = (2, 1)
_VERSION: _Members = {
    "firmware_major_version_number": _FIRMWARE[0],
    "firmware_minor_version_number": _FIRMWARE[1],
}
_REACH: _Members = {"max_distance": 160_000.0, "min_distance": 1500.0}
_AT401, _AT901 = (equipment.LTSensorType.AT401, "AT401"), (equipment.LTSensorType.AT901_MR, "AT901-MR")
_FIRST_SERIAL = 390_000
_SEEDS = 10_000
_REFLECTORS = (
    (equipment.TargetType.RRR05, "RRR 0.5in", 6.35),
    (equipment.TargetType.RRR15, "RRR 1.5in", 19.05),
    (equipment.TargetType.BRR15, "BRR 1.5in", 19.05),
    (equipment.TargetType.TBR05, "TBR 0.5in", 6.35),
)
REFLECTOR_IDS = range(1, len(_REFLECTORS) + 1)
COMPENSATION_IDS = range(1, 2)


def serial_number(cell: Cell) -> int:
    """Return the serial number of the tracker that stands in a cell now."""
    own = _FIRST_SERIAL + cell.seed % _SEEDS
    return int(cell.faults.serial("tracker", str(own), cell.clock.now_s))


def reflectors() -> list[Record]:
    """Return the members of the reflector list, surface offsets in mm."""
    return [
        Record(
            total_reflectors=len(_REFLECTORS),
            internal_reflector_id=number,
            target_type=kind,
            surface_offset=offset_mm,
            reflector_name=name,
        )
        for number, (kind, name, offset_mm) in zip(REFLECTOR_IDS, _REFLECTORS, strict=True)
    ]


def compensation(command: Command) -> Record:
    """Return the only entry of the list of compensations, in either form."""
    return _members(
        command,
        total_compensations=1,
        internal_compensation_id=1,
        tracker_compensation_name="factory",
        adm_compensation_name="factory",
        is_active=True,
    )


def description(command: int, cell: Cell) -> Record | None:
    """Return the answer to an information command, None when it is none; lengths in mm, angles in rad."""
    serial = serial_number(cell)
    head = _descriptions_of_head(serial, *(_AT401 if cell.scenario.probe is None else _AT901))
    members = {**head, **_descriptions_of_sensors(serial)}.get(command)
    return None if members is None else _members(Command(command), **members)


def _members(command: Command, **values: int | float | str) -> Record:
    """Fill an answer's members; those without a meaning here stay zero."""
    record = EXCHANGES[command].answer.zeros()
    record.update({name: value for name, value in values.items() if name in record})
    return record


def _descriptions_of_head(serial: int, kind: equipment.LTSensorType, name: str) -> Mapping[int, _Members]:
    """Return what describes the tracker as a whole."""
    tracker: _Members = {"tracker_type": kind, "tracker_name": name, "serial_number": serial}
    return {
        Command.GET_TRACKER_INFO: {
            **tracker, **_REACH, "compensation_id_number": 1, "has_adm": True, "has_nivel": True,
            "max_data_rate": 50, "number_of_faces": 2,
            "hz_angle_range": 2.0 * math.pi, "vt_angle_range": math.radians(290.0),
            "accuracy_model": equipment.TrkAccuracyModel.MODEL_2005, "maj_lcp_firmware_version": _FIRMWARE[0],
            "min_lcp_firmware_version": _FIRMWARE[1],
        },
        Command.GET_AT4XX_INFO: {
            **tracker, **_REACH,
            "major_firmware_version": _FIRMWARE[0], "minor_firmware_version": _FIRMWARE[1],
            "major_server_software_version": SERVER_VERSION[0],
            "minor_server_software_version": SERVER_VERSION[1],
            "server_software_build_number": SERVER_VERSION[2],
            "wlan_type": equipment.WLANType.NONE, "xscale_type": equipment.TPMicroProcessorType.PXA250,
            "min_measure_time": 100, "std_dev_dist_offset_adm": 0.010, "std_dev_angle_const": 2.4e-6,
        },
        Command.GET_TP_INFO: {
            "tp_boot_major_version_number": 1,
            "tp_firmware_major_version_number": _FIRMWARE[0],
            "tp_firmware_minor_version_number": _FIRMWARE[1],
            "trackerprocessor_type": equipment.TrackerProcessorType.ATC400,
            "micro_processor_type": equipment.TPMicroProcessorType.PXA250,
            "micro_processor_clock_speed": 400,
            "laser_tracker_sensor_type": kind,
        },
        Command.GET_SYSTEM_SOFTWARE_VERSION: {
            "software_version": ".".join(map(str, SERVER_VERSION)) + " simulated"
        },
    }  # fmt: skip


def _descriptions_of_sensors(serial: int) -> Mapping[int, _Members]:
    """Return what describes the instruments inside and beside the head."""
    numbered: _Members = {**_VERSION, "serial_number": serial}
    return {
        Command.GET_ADM_INFO: numbered,
        Command.GET_ADM_INFO2: {
            **numbered, **_REACH, "adm_type": equipment.ADMType.LEICA_ADM2, "adm_name": "ADM",
            "max_data_rate": 50, "accuracy_adm_distance": 0.010,
        },
        Command.GET_NIVEL_INFO: numbered,
        Command.GET_NIVEL_INFO2: {
            **numbered, "nivel_type": equipment.NivelType.NIVEL_AT4XX, "nivel_name": "AT4xx",
            "measurement_range": 0.05,
        },
        Command.GET_ATR_INFO: {
            **_REACH, "atr_type": equipment.ATRType.ATR_5I, "atr_name": "ATR",
            "maj_firmware_version": _FIRMWARE[0], "min_firmware_version": _FIRMWARE[1],
            "field_of_view": 0.026,
        },
        Command.GET_METEO_STATION_INFO: {
            **_VERSION, "meteo_station_type": equipment.MeteoStationType.AT, "identifier": f"AT {serial}",
        },
        Command.GET_OVERVIEW_CAMERA_INFO: {"camera_type": equipment.OverviewCameraType.UNKNOWN},
        Command.GET_TRIGGER_BOARD_INFO: {"trigger_card_type": equipment.TriggerCardType.NONE},
    }  # fmt: skip


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

    def handlers(self) -> dict[int, Handler]:
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
                    equipment.TrackerProcessorStatus.INITIALIZED
                    if ready
                    else equipment.TrackerProcessorStatus.COMPENSATION_SET
                ),
                laser_status=equipment.LaserProcessorStatus.LASER_READY,
                adm_status=equipment.ADMStatus.ADM_READY,
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
        status = equipment.TrackerStatus.READY if locked else equipment.TrackerStatus.NOT_READY
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
        yield Answer(request.command, values=Record(tracker_face=equipment.TrackerFace(self._tracker.face)))

    def _object_temperature(self, request: Request) -> Steps:
        sensed_c = self._cell.air.sensed_c(self._cell.clock.now_s, self._cell.noise)
        shown = self._settings.units.to_wire(Quantity.TEMPERATURE, sensed_c)
        yield Answer(request.command, values=Record(object_temperature=shown))
