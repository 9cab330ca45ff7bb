"""A probe of six degrees of freedom on the flange: what it shows, and its stationary poses as packets.

The tracker follows it by itself: what hides it breaks the measurement, and what shows it again ends that.

Rotations come in the user's frame as quaternion and as the angles of RotX RotY RotZ.
"""

import math
from dataclasses import dataclass

import numpy as np

from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.protocol.equipment import (
    MeasurementTipStatus,
    ProbeType,
    TriggerStatus,
)
from truepose_drivers.leica_emscon.protocol.settings import MeasMode
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import BeamBrokenError, ScenarioError
from truepose_simulators.faults.kinds import TrackerBlinded
from truepose_simulators.instruments.accuracy import ProbeSetup, face_error_mm, noise_mm
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity
from truepose_simulators.instruments.leica_emscon.results import (
    coordinates,
    covariances,
    deviations,
    total,
)
from truepose_simulators.instruments.leica_emscon.settings import Handler, ServerSettings
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.physics.rigid import FloatArray, register, rotation, to_quaternion

_OF_THE_PROBE = 0x6D  # its own chances: those of the other instruments stay as they are


@dataclass(frozen=True, slots=True)
class PoseMeasured:
    """One stationary measurement of the probe, tracker frame."""

    position_mm: FloatArray  # (3,)
    rotation: FloatArray  # (3, 3)
    covariance_mm2: FloatArray  # (3, 3) of the position, by the accuracy model
    rotation_rad: float  # standard deviation about each axis
    turned_away: bool  # farther than its lamps can be seen
    too_far: bool


class Probe:
    """The probe of a cell; knows no protocol."""

    def __init__(self, cell: Cell, setup: ProbeSetup) -> None:
        """Sit on the flange; raises ScenarioError for a tool whose nests make no frame."""
        self._frame_mm = np.array(cell.scenario.tool.nests_mm)
        if len(self._frame_mm) < 3:
            raise ScenarioError(f"[probe]: a tool with {len(self._frame_mm)} nests has no frame: give three")
        self._cell = cell
        self._setup = setup
        self._facing = np.array(setup.facing) / np.linalg.norm(setup.facing)
        self._rng = np.random.default_rng([cell.seed, _OF_THE_PROBE])

    def pose(self) -> FloatArray:
        """Return the probe's frame in the tracker's now, shape (4, 4); raises BeamBrokenError."""
        now_s = self._cell.clock.now_s
        if self._cell.faults.holds(TrackerBlinded, now_s):
            raise BeamBrokenError("the probe no longer returns the beam")
        return register(
            self._frame_mm, in_tracker_frame(self._cell.tracker.frame, self._cell.nests_at_mm(now_s))
        )

    def measure(self) -> PoseMeasured:
        """Measure the probe as it is now; raises BeamBrokenError."""
        pose = self.pose()
        position_mm, turned = pose[:3, 3], pose[:3, :3]
        tracker = self._cell.tracker
        covariance = tracker.covariance_mm2(position_mm)
        off_rad = self._off_rad(position_mm, turned @ self._facing)
        if self._cell.noise is not None:
            position_mm = position_mm + face_error_mm(tracker.setup, position_mm, tracker.face)
            position_mm = position_mm + noise_mm(tracker.setup, position_mm, self._rng)
            turned = rotation(self._setup.rotation_rad * self._rng.standard_normal(3)) @ turned
        return PoseMeasured(
            position_mm,
            turned,
            covariance,
            self._setup.rotation_rad,
            off_rad > math.radians(self._setup.acceptance_deg),
            float(np.linalg.norm(position_mm)) > self._setup.reach_mm,
        )

    @staticmethod
    def _off_rad(position_mm: FloatArray, facing: FloatArray) -> float:
        towards = -position_mm / np.linalg.norm(position_mm)
        return math.acos(float(np.clip(facing @ towards, -1.0, 1.0)))


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

    def handlers(self) -> dict[int, Handler]:
        """Return the commands that tell of the probe; none of them changes anything."""
        ids = {
            protocol.Command.GET_PROBE: "internal_probe_id",
            protocol.Command.GET_PROBE_COMPENSATION: "internal_probe_compensation_id",
            protocol.Command.GET_T_CAM_TO_TRACKER_COMPENSATION: "internal_t_cam_to_tracker_compensation_id",
        }
        told = {command: protocol.Record({member: _ID}) for command, member in ids.items()}
        told[protocol.Command.GET_PROBES] = protocol.Record(
            protocol.EXCHANGES[protocol.Command.GET_PROBES].answer.zeros(),
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

    def result(self, duration_s: float, before_mm: FloatArray, air: protocol.Record) -> protocol.Result:
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

    def _packet(self, pose: PoseMeasured, air: protocol.Record) -> protocol.Result:
        members = protocol.Record(
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
        return protocol.Result(protocol.PacketType.STATIONARY_PROBE_MEAS_RESULT, members)

    def _position(self, pose: PoseMeasured) -> protocol.Record:
        shown = self._settings.view.covariance_to_wire(pose.position_mm, pose.covariance_mm2)
        values = coordinates(self._settings, pose.position_mm)
        members = protocol.Record({f"position{axis}": values[f"val{axis}"] for axis in (1, 2, 3)})
        for name in ("", "apriori_"):
            members.update(
                deviations(f"{name}std_dev_position", shown), **covariances(f"{name}covar_position", shown)
            )
            members[f"{name}std_dev_position_total"] = total(pose.covariance_mm2, self._settings)
        return members

    def _rotation(self, pose: PoseMeasured) -> protocol.Record:
        turned = self._settings.view.placement[:3, :3] @ pose.rotation
        members = protocol.Record({
            f"quaternion{i}": float(part) for i, part in enumerate(to_quaternion(turned))
        })
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


def _teller(values: protocol.Record) -> Handler:
    return lambda request: iter([protocol.Answer(request.command, values=values)])


def _worth(pose: PoseMeasured) -> int:
    if pose.turned_away:
        return protocol.RotationStatus.ERROR | protocol.RotationStatus.ANGLE_OUT_OF_RANGE
    if pose.too_far:
        return protocol.RotationStatus.ERROR | protocol.RotationStatus.DISTANCE_OUT_OF_RANGE
    return protocol.RotationStatus.VALID


def _angles_rad(turned: FloatArray) -> tuple[float, float, float]:
    """Return the angles of RotX RotY RotZ."""
    (a, b, c), (_, _, f), (_, _, i) = np.asarray(turned).tolist()
    return math.atan2(-f, i), math.asin(max(-1.0, min(1.0, c))), math.atan2(-b, a)
