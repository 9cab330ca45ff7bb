"""The probe behind the protocol: which it is, and its stationary poses as result packets.

Rotations come in the user's frame as quaternion and as the angles of RotX RotY RotZ.
"""

import math
from collections.abc import Callable

import numpy as np

from truepose_drivers.leica_emscon.protocol import (
    EXCHANGES,
    Answer,
    Command,
    PacketType,
    Record,
    Request,
    Result,
    RotationStatus,
)
from truepose_drivers.leica_emscon.protocol.equipment import (
    MeasurementTipStatus,
    ProbeType,
    TriggerStatus,
)
from truepose_drivers.leica_emscon.protocol.settings import MeasMode
from truepose_simulators.errors import BeamBrokenError
from truepose_simulators.instruments.tracker.leica_emscon.measuring import (
    coordinates,
    covariances,
    deviations,
    total,
)
from truepose_simulators.instruments.tracker.leica_emscon.settings import ServerSettings
from truepose_simulators.instruments.tracker.leica_emscon.steps import Steps
from truepose_simulators.instruments.tracker.leica_emscon.units import Quantity
from truepose_simulators.instruments.tracker.probe import PoseMeasured, Probe
from truepose_simulators.physics.rigid import FloatArray, to_quaternion

_ID = 1  # of the probe and of each of its compensations
_NO_TIP = {
    "tip_status": MeasurementTipStatus.TIP_OK,
    "internal_tip_adapter_id": 0,
    "tip_adapter_interface": 0,
}
_SERIAL = 4711


class Poses:
    """The probe as subject of a measurement."""

    def __init__(self, probe: Probe, settings: ServerSettings) -> None:
        self._probe = probe
        self._settings = settings
        self._lost = False

    def handlers(self) -> dict[int, Callable[[Request], Steps]]:
        """Return the commands that tell of the probe; none of them changes anything."""
        ids = {
            Command.GET_PROBE: "internal_probe_id",
            Command.GET_PROBE_COMPENSATION: "internal_probe_compensation_id",
            Command.GET_T_CAM_TO_TRACKER_COMPENSATION: "internal_t_cam_to_tracker_compensation_id",
        }
        told = {command: Record({member: _ID}) for command, member in ids.items()}
        told[Command.GET_PROBES] = Record(
            EXCHANGES[Command.GET_PROBES].answer.zeros(),
            total_probes=1,
            internal_probe_id=_ID,
            serial_number=_SERIAL,
            probe_type=ProbeType.MACHINE_CONTROL_PROBE_MULTI_SIDE,
            number_of_fields=4,
            name="T-Mac",
        )
        return {command: _teller(values) for command, values in told.items()}

    def sight(self) -> FloatArray:
        """Return where it is now; raises BeamError."""
        position_mm: FloatArray = self._probe.pose()[:3, 3]
        return position_mm

    def lose(self) -> None:
        """Let the measurement under way fail; the tracker finds the probe again by itself."""
        self._lost = True

    def result(self, duration_s: float, before_mm: FloatArray, air: Record) -> Result:
        """Measure it; raises BeamError."""
        del duration_s, before_mm  # a probe is not measured while the arm moves
        lost, self._lost = self._lost, False
        if lost:
            raise BeamBrokenError("something crossed the beam to the probe")
        return self._packet(self._probe.measure(), air)

    def position(self, duration_s: float) -> FloatArray:
        """Return one quick reading of where it is; raises BeamError."""
        del duration_s
        return self._probe.measure().position_mm

    def _packet(self, pose: PoseMeasured, air: Record) -> Result:
        members = Record(
            _NO_TIP,
            meas_mode=MeasMode.STATIONARY_6D,
            is_try_mode=False,
            trigger_status=TriggerStatus.TRIGGER_NOT_PRESSED,
            rotation_status=_worth(pose),
            internal_probe_id=_ID,
            field_number=0,
            **air,
        )
        members.update(self._position(pose), **self._rotation(pose))
        return Result(PacketType.STATIONARY_PROBE_MEAS_RESULT, members)

    def _position(self, pose: PoseMeasured) -> Record:
        shown = self._settings.view.covariance_to_wire(pose.position_mm, pose.covariance_mm2)
        values = coordinates(self._settings, pose.position_mm)
        members = Record({f"position{axis}": values[f"val{axis}"] for axis in (1, 2, 3)})
        for name in ("", "apriori_"):
            members.update(
                deviations(f"{name}std_dev_position", shown), **covariances(f"{name}covar_position", shown)
            )
            members[f"{name}std_dev_position_total"] = total(pose.covariance_mm2, self._settings)
        return members

    def _rotation(self, pose: PoseMeasured) -> Record:
        turned = self._settings.view.placement[:3, :3] @ pose.rotation
        members = Record({f"quaternion{i}": float(part) for i, part in enumerate(to_quaternion(turned))})
        angle_to_wire = self._settings.units.to_wire
        for axis, angle in zip("xyz", _angles_rad(turned), strict=True):
            members[f"rotation_angle_{axis}"] = angle_to_wire(Quantity.ANGLE, angle)
        deviation = angle_to_wire(Quantity.ANGLE, pose.rotation_rad)
        for name in ("", "apriori_"):
            for axis in "xyz":
                members[f"{name}std_dev_rotation_angle_{axis}"] = deviation
            members[f"{name}std_dev_rotation_angle_total"] = math.sqrt(3.0) * deviation
            for pair in ("xy", "xz", "yz"):
                members[f"{name}covar_rotation_angle_{pair}"] = 0.0
        return members


def _teller(values: Record) -> Callable[[Request], Steps]:
    return lambda request: iter([Answer(request.command, values=values)])


def _worth(pose: PoseMeasured) -> int:
    if pose.turned_away:
        return RotationStatus.ERROR | RotationStatus.ANGLE_OUT_OF_RANGE
    if pose.too_far:
        return RotationStatus.ERROR | RotationStatus.DISTANCE_OUT_OF_RANGE
    return RotationStatus.VALID


def _angles_rad(turned: FloatArray) -> tuple[float, float, float]:
    """Return the angles of RotX RotY RotZ."""
    (a, b, c), (_, _, f), (_, _, i) = np.asarray(turned).tolist()
    return math.atan2(-f, i), math.asin(max(-1.0, min(1.0, c))), math.atan2(-b, a)
