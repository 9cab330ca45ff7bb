"""What a result status means to the operator: the error to raise and what to do about it.

Names of the statuses are those of the emScon SDK 3.6 header; which of them a tracker gives in which
situation is partly inferred (see README) and never tried on hardware.
"""

from collections.abc import Mapping
from typing import Literal, TypeAlias

from truepose_drivers.errors import (
    ArtefactNotSeenError,
    BeamBrokenError,
    BusyError,
    DeviceRefusedError,
    DriverError,
    MeasurementFailedError,
    NotInitialisedError,
    ReflectorNotFoundError,
)
from truepose_drivers.leica_emscon.protocol import Command, ResultStatus

Purpose: TypeAlias = Literal["set", "find", "measure", "measure_pose"]
"""What a command is for: one status says "no reflector" to a search, "beam broken" to a measurement."""


class CommandUnknownError(DeviceRefusedError):
    """The command exists in the protocol but not in the tracker that was asked."""


_BUSY: Mapping[int, str] = {
    ResultStatus.SERVER_BUSY: "it is busy with another command: wait for it to end, then repeat",
    ResultStatus.INTERNAL_PROCESS_ACTIVE: "an internal process is running: wait for it to end, then repeat",
    ResultStatus.IN_COMPENSATION_MODE: "a compensation is under way: finish it at the tracker's own program",
    ResultStatus.ADM_START_UP_BUSY: "its distance meter is starting up: wait a minute, then repeat",
    ResultStatus.SENSOR_NOT_WARMED_UP: "it is not warmed up: wait until it is, then initialise",
    ResultStatus.SENSOR_NOT_STABLE: "it is not stable: wait until its stand is free of vibration, then"
    " repeat",
    ResultStatus.SYSTEM_NOT_READY_FOR_MEASUREMENT: "it is not ready to measure: wait, then repeat",
}

_REFUSED: Mapping[int, str] = {
    ResultStatus.NO_WEATHERMONITOR_FOUND: "no weather station was found: connect it, then initialise",
    ResultStatus.NO_TEMPERATURE_FROM_WM: "the weather station gives no temperature: check its sensor",
    ResultStatus.NO_PRESSURE_FROM_WM: "the weather station gives no pressure: check its sensor",
    ResultStatus.NO_HUMIDITY_FROM_WM: "the weather station gives no humidity: check its sensor",
    ResultStatus.METEO_DATA_OUT_OF_RANGE: "the air is out of its range: check the weather station",
    ResultStatus.PRESSURE_SENSOR_PROBLEM: "its pressure sensor fails: have it serviced",
    ResultStatus.NO_TRACKER_CONNECTED: "no sensor is connected to the controller: check the sensor cable",
    ResultStatus.COMMUNICATION_WITH_SENSOR_FAILED: "the controller cannot reach the sensor: check its cable",
    ResultStatus.NO_SENSOR_BATTERY: "the sensor has no battery: put one in",
    ResultStatus.SENSOR_NOT_LEVELED: "it is not levelled: level the stand, then initialise",
    ResultStatus.NOT_LEVELED_FOR_INITIALIZATION: "it is not levelled: level the stand, then initialise",
    ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED: (
        "another program is connected to it, or it has not noticed yet that a connection broke: close that"
        " program, or wait a minute"
    ),
    ResultStatus.TP_EXTERNAL_CONTROL: "another program controls it: close that one first",
    ResultStatus.NO_VALID_ADM_COMPENSATION: "its distance meter has no valid compensation: have it serviced",
    ResultStatus.ADM_HARDWARE_PROBLEM: "its distance meter is defective: have it serviced",
    ResultStatus.ATR_HARDWARE_PROBLEM: "its target recognition is defective: have it serviced",
    ResultStatus.LICENSE_EXPIRED: "its licence has expired: ask the manufacturer",
    ResultStatus.MODE_NOT_ALLOWED_6D: "it cannot measure poses in its present state: check its camera and"
    " the probe",
    ResultStatus.NO_MEASUREMENTCAMERA: "it has no probe camera: mount it",
    ResultStatus.NO_ACTIVE_MEASUREMENTCAMERA: "its probe camera is not active: activate it in the tracker's"
    " own program",
    ResultStatus.COMMUNICATION_WITH_MEASUREMENTCAMERA_FAILED: "it cannot reach its camera: check the cable",
    ResultStatus.NO_CAMERA_TO_TRACKER_COMP_SET: "its camera is not compensated: see the tracker's own"
    " program",
    ResultStatus.NO_MEASUREMENTPROBE: "it does not see a probe: guide the beam to the probe",
    ResultStatus.NO_ACTIVE_MEASUREMENTPROBE: "it does not see a probe: guide the beam to the probe",
    ResultStatus.COMMUNICATION_WITH_MEASUREMENTPROBE_FAILED: "it cannot reach the probe: switch the probe on",
    ResultStatus.NO_MEASUREMENTPROBE_COMP_SET: "the probe is not compensated: see the tracker's own program",
    ResultStatus.MEASUREMENT_FACE2_NOT_ALLOWED_6D: "it is in face 2, but poses need face 1: change the face",
}

_WRONG_PARAMETERS = frozenset({
    ResultStatus.WRONG_PARAMETER,
    *range(ResultStatus.WRONG_PARAMETER_1, ResultStatus.PARAMETER_6_OUT_OF_RANGE_NOK + 1),
    *range(ResultStatus.WRONG_PARAMETER_8, ResultStatus.WRONG_PARAMETER_16 + 1),
})

_NO_REFLECTOR = frozenset({
    ResultStatus.UNKNOWN,
    ResultStatus.NO_DISTANCE_SET,
    ResultStatus.WRONG_CURRENT_REFLECTOR,
    ResultStatus.NO_STATIONARY_RESULT,
    ResultStatus.MEASUREMENT_STATUS_NOT_READY,
})

_NO_PROBE = _NO_REFLECTOR | {
    ResultStatus.BAD_6D_RESULT,
    ResultStatus.NO_MEASUREMENTPROBE,
    ResultStatus.NO_ACTIVE_MEASUREMENTPROBE,
}

_COMMANDS: Mapping[int, str] = {int(member): member.name for member in Command}  # one sentence a request

_CONCERNS_CONNECTION = frozenset({
    ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED,
    ResultStatus.NO_TRACKER_CONNECTED,
})


def concerns_connection(status: int) -> bool:
    """Whether an error packet of this status matters whatever command it names."""
    return status in _CONCERNS_CONNECTION


def error_for(command: int, status: int, purpose: Purpose) -> DriverError:
    """Return the error that a status other than 0 means, with a sentence for the operator."""
    name = command_name(command)
    if status in _BUSY:
        return BusyError(f"the tracker refused {name}: {_BUSY[status]}")
    if status == ResultStatus.TRACKER_NOT_INITIALIZED:
        return NotInitialisedError(f"the tracker refused {name}: it is not initialised, initialise it first")
    if status == ResultStatus.NOT_IMPLEMENTED:
        return CommandUnknownError(f"the tracker refused {name}: this model does not support the command")
    # Before the refusals, which know these statuses too: during a measurement they mean a hidden probe, which
    # a person can clear, and not a tracker without one.
    if purpose == "measure_pose" and status in _NO_PROBE:
        return ArtefactNotSeenError(
            f"the tracker does not see the probe ({name}, {_status_name(status)}): clear the line of sight,"
            " guide the beam to the probe, then repeat the configuration"
        )
    if status in _REFUSED:
        return DeviceRefusedError(f"the tracker refused {name}: {_REFUSED[status]}")
    if status in _WRONG_PARAMETERS:
        return DeviceRefusedError(f"the tracker refused a value of {name} ({_status_name(status)})")
    if purpose == "find" and status in _NO_REFLECTOR:
        return ReflectorNotFoundError(
            f"no reflector found where the tracker searched ({name}, {_status_name(status)}):"
            " check that it sits in its nest, faces the tracker and nothing blocks the beam"
        )
    if purpose == "measure" and status in _NO_REFLECTOR:
        return BeamBrokenError(
            f"the beam was interrupted or the reflector was lost ({name}, {_status_name(status)}):"
            " clear the line of sight, then repeat the configuration"
        )
    return _other(name, status, purpose)


def _other(name: str, status: int, purpose: Purpose) -> DriverError:
    kind = DeviceRefusedError if purpose == "set" else MeasurementFailedError
    return kind(f"the tracker answered {name} with {_status_name(status)}: see its manual for this status")


def command_name(command: int) -> str:
    """Return the header's name of a command, for error texts."""
    return _COMMANDS.get(command, f"command {command}")


def _status_name(status: int) -> str:
    known = {int(member): member.name for member in ResultStatus}
    return f"status {status} {known.get(status, '(unknown to this program)')}"
