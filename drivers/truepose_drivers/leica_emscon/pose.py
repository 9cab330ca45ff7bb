"""What the result of a probe says: whether it is a pose at all, and which."""

import math
from collections.abc import Mapping
from typing import Final

from truepose_drivers.api import Quaternion
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    DeviceRefusedError,
    DriverError,
    OutOfVolumeError,
    RemoteProtocolError,
)
from truepose_drivers.leica_emscon.protocol import Record, RotationStatus
from truepose_drivers.leica_emscon.protocol.equipment import MeasurementTipStatus
from truepose_drivers.leica_emscon.protocol.settings import MeasMode

_ROUNDED: Final = 1e-3  # by so much a quaternion's length may differ from 1: more is damage, not rounding
_ANGLES: Final = ("rotation_angle_x", "rotation_angle_y", "rotation_angle_z")
_POSITION: Final = ("position1", "position2", "position3")

_UNFIT: Mapping[RotationStatus, DriverError] = {
    RotationStatus.FROZEN: RemoteProtocolError("the tracker repeats a frozen orientation: connect again"),
    RotationStatus.NOT_ENOUGH_LEDS: ArtefactNotSeenError(
        "the tracker's camera sees too few lamps of the probe: clear its view, turn the probe towards it,"
        " then repeat the configuration"
    ),
    RotationStatus.RMS_TOO_HIGH: ArtefactNotSeenError(
        "the lamps of the probe do not fit its compensation: clear the view of the camera, then repeat the"
        " configuration; if it comes back, have the probe compensated"
    ),
    RotationStatus.ANGLE_OUT_OF_RANGE: OutOfVolumeError(
        "the probe is turned too far away from the tracker: choose another configuration"
    ),
    RotationStatus.DISTANCE_OUT_OF_RANGE: OutOfVolumeError(
        "the probe is too near to the tracker or too far from it: choose another configuration"
    ),
}


def require_stationary_pose(values: Record) -> None:
    """Raise RemoteProtocolError for a result that is no pose, MeasurementFailedError for an unfit one."""
    if values.integer("meas_mode") != MeasMode.STATIONARY_6D or values.integer("is_try_mode"):
        raise RemoteProtocolError("the tracker measured in another mode than asked for: initialise it")
    if values.integer("tip_status") != MeasurementTipStatus.TIP_OK:
        raise DeviceRefusedError("the probe has a tip that the tracker does not know, or several: remove it")
    _require_fit(values.integer("rotation_status"))
    position_mm = values.vector(*_POSITION)
    if not all(map(math.isfinite, (*position_mm, *values.vector(*_ANGLES)))):
        raise RemoteProtocolError(f"the tracker measured {position_mm}: that is no position")
    unit_quaternion(values)


def unit_quaternion(values: Record) -> Quaternion:
    """Return the orientation; raises RemoteProtocolError where the four numbers are none."""
    q0, qx, qy, qz = (values.number(f"quaternion{index}") for index in range(4))
    length = math.hypot(q0, qx, qy, qz)
    if not abs(length - 1.0) <= _ROUNDED:  # a NaN is not
        raise RemoteProtocolError(f"the tracker states a quaternion of length {length:.6g}: connect again")
    return q0 / length, qx / length, qy / length, qz / length


def _require_fit(status: int) -> None:
    for bit, error in _UNFIT.items():
        if status & bit:
            raise type(error)(*error.args)
    if status & RotationStatus.ERROR or not status & RotationStatus.VALID:
        raise ArtefactNotSeenError(
            "the tracker does not vouch for the orientation of the probe: clear the line of sight, then"
            " repeat the configuration"
        )
