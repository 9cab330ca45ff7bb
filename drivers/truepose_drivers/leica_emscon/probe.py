"""A Leica laser tracker with a probe of six degrees of freedom (T-Mac, T-Probe): stationary poses of it."""

import contextlib
import math
from collections.abc import Mapping
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DriverPlugin, Options, PoseReading, Quaternion, Vector
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    DeviceRefusedError,
    DriverError,
    NotInitialisedError,
    OutOfVolumeError,
    RemoteProtocolError,
)
from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.conversation import Subject
from truepose_drivers.leica_emscon.coordinate_settings import COMPENSATION, Setting, mode
from truepose_drivers.leica_emscon.error_codes import CommandUnknownError
from truepose_drivers.leica_emscon.instrument import EmsconInstrument, TimeOuts, require_deviations
from truepose_drivers.leica_emscon.protocol.equipment import MeasurementTipStatus, ProbeType
from truepose_drivers.leica_emscon.protocol.settings import MeasMode, SystemParameter
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import tcp_link

_ROUNDED: Final = 1e-3  # by so much a quaternion's length may differ from 1: more is damage, not rounding
_ANGLES: Final = ("rotation_angle_x", "rotation_angle_y", "rotation_angle_z")
_DEVIATIONS: Final = ("std_dev_position1", "std_dev_position2", "std_dev_position3")
_TURN_DEVIATION: Final = "std_dev_rotation_angle_total"
_POSITION: Final = ("position1", "position2", "position3")

_UNFIT: Mapping[protocol.RotationStatus, DriverError] = {
    protocol.RotationStatus.FROZEN: RemoteProtocolError(
        "the tracker repeats an old orientation: connect again"
    ),
    protocol.RotationStatus.NOT_ENOUGH_LEDS: ArtefactNotSeenError(
        "the tracker's camera sees too few LEDs of the probe: clear its view, turn the probe towards it,"
        " then repeat the configuration"
    ),
    protocol.RotationStatus.RMS_TOO_HIGH: ArtefactNotSeenError(
        "the LEDs of the probe do not fit its compensation: clear the view of the camera, then repeat the"
        " configuration; if it happens again, have the probe compensated"
    ),
    protocol.RotationStatus.ANGLE_OUT_OF_RANGE: OutOfVolumeError(
        "the probe points too far away from the tracker: choose another configuration"
    ),
    protocol.RotationStatus.DISTANCE_OUT_OF_RANGE: OutOfVolumeError(
        "the probe is too close to the tracker or too far from it: choose another configuration"
    ),
}


def require_stationary_pose(values: protocol.Record) -> None:
    """Raise RemoteProtocolError for a result that is no pose, MeasurementFailedError for an unfit one."""
    if values.integer("meas_mode") != MeasMode.STATIONARY_6D or values.integer("is_try_mode"):
        raise RemoteProtocolError("the tracker measured in a mode other than requested: initialise it")
    if values.integer("tip_status") != MeasurementTipStatus.TIP_OK:
        raise DeviceRefusedError("the probe has a tip that the tracker does not know, or several: remove it")
    _require_fit(values.integer("rotation_status"))
    position_mm = values.vector(*_POSITION)
    if not all(map(math.isfinite, (*position_mm, *values.vector(*_ANGLES)))):
        raise RemoteProtocolError(f"the tracker measured {position_mm}: not a valid position")
    unit_quaternion(values)
    require_deviations(values, *_DEVIATIONS, _TURN_DEVIATION)


def unit_quaternion(values: protocol.Record) -> Quaternion:
    """Return the orientation; raises RemoteProtocolError where the four numbers are none."""
    q0, qx, qy, qz = (values.number(f"quaternion{index}") for index in range(4))
    length = math.hypot(q0, qx, qy, qz)
    if not abs(length - 1.0) <= _ROUNDED:  # a NaN is not
        raise RemoteProtocolError(f"the tracker reports a quaternion of length {length:.6g}: connect again")
    return q0 / length, qx / length, qy / length, qz / length


def _require_fit(status: int) -> None:
    for bit, error in _UNFIT.items():
        if status & bit:
            # A new one each time: an exception keeps its traceback and its cause, and the table lives on.
            raise type(error)(*error.args)
    if status & protocol.RotationStatus.ERROR or not status & protocol.RotationStatus.VALID:
        raise ArtefactNotSeenError(
            "the tracker marks the orientation of the probe as unreliable: clear the line of sight, then"
            " repeat the configuration"
        )


_POSES = Subject(frozenset({protocol.PacketType.STATIONARY_PROBE_MEAS_RESULT}), "measure_pose")
_TIP = ("internal_tip_adapter_id", "tip_adapter_interface")
# A pose depends on all of them; which they are is the business of the tracker's own program.
_COMPENSATIONS = (
    COMPENSATION,
    Setting(
        "compensation of its camera",
        protocol.Command.GET_T_CAM_TO_TRACKER_COMPENSATION,
        kept=("internal_t_cam_to_tracker_compensation_id",),
    ),
    Setting(
        "compensation of the probe",
        protocol.Command.GET_PROBE_COMPENSATION,
        kept=("internal_probe_compensation_id",),
    ),
)


class ProbeTracker(EmsconInstrument):
    """An emScon tracker that measures the probe its beam is on.

    `probe` is the name of the probe that must be there; without it any will do. The tracker knows a probe by
    itself, and follows it while the arm moves.
    """

    def __init__(
        self, link: Link, clock: Clock, *, probe: str | None = None, time_outs: TimeOuts | None = None
    ) -> None:
        super().__init__(link, clock, _POSES, time_outs)
        self._wanted = probe
        self._probe_id: protocol.Value | None = None
        self._tip: tuple[protocol.Value, ...] | None = (
            None  # that was measured since initialising; none is one too
        )

    async def initialise(self) -> None:
        """Set units, mode and frame, and see which probe is there; start up the tracker where needed.

        Raises NotInitialisedError when it does not come up, DeviceRefusedError when it cannot measure poses,
        sees no probe, or another than the one that is asked for.
        """
        try:
            await self._prepare(protocol.Record(meas_mode=MeasMode.STATIONARY_6D))
        except CommandUnknownError as error:
            raise DeviceRefusedError(
                f"this tracker measures points, not poses ({error}): use the driver leica_emscon"
            ) from error
        await self._catch_the_beam_again()
        probe = await self._present_probe()
        self._tip = None
        self._probe_id = probe["internal_probe_id"]
        number = protocol.Record(internal_probe_id=self._probe_id)
        await self._settle(
            _probe_sentence(probe),
            mode(MeasMode.STATIONARY_6D),
            Setting("probe", protocol.Command.GET_PROBE, number),
            *_COMPENSATIONS,
        )

    async def measure_pose(self, *, duration_s: float) -> PoseReading:
        """Average over `duration_s`; raises ArtefactNotSeenError, OutOfVolumeError."""
        await self._require_prepared()
        values = await self._measured(duration_s)
        return PoseReading(
            quaternion=unit_quaternion(values),
            position_mm=values.vector(*_POSITION),
            position_deviation_mm=values.vector(*_DEVIATIONS),
            rotation_deviation_rad=values.number(_TURN_DEVIATION),
            rms_mm=math.nan,  # emScon judges the fit of the lamps by itself, and states no figure
            frames=1,  # it averages inside and does not say over how many
            duration_s=duration_s,
            time_s=await self._clock.now_s(),
        )

    async def _catch_the_beam_again(self) -> None:
        """Have the tracker find a probe that was hidden, where it can."""
        power_lock = protocol.Record(system_param=SystemParameter.POWER_LOCK_FUNCTION_ACTIVE, parameter=1)
        with contextlib.suppress(DeviceRefusedError):
            await self._ask(protocol.Command.SET_LONG_SYSTEM_PARAMETER, power_lock)

    async def _present_probe(self) -> protocol.Record:
        """Return the probe that the beam is on, by the tracker's list."""
        # The tracker knows a probe by itself, no command chooses one: so it is asked which one is there.
        present = (await self._ask(protocol.Command.GET_PROBE))["internal_probe_id"]
        known = await self._conversation.ask_list(
            protocol.Command.GET_PROBES, timeout_s=self._time_outs.command_s
        )
        for probe in known:
            if probe["internal_probe_id"] == present:
                return self._required(probe)
        raise DeviceRefusedError("the tracker does not see a known probe: guide the beam to the probe")

    def _required(self, probe: protocol.Record) -> protocol.Record:
        name = probe.text("name")
        if self._wanted not in (None, name):
            raise DeviceRefusedError(
                f"the tracker sees the probe {name!r}, option probe names {self._wanted!r}: mount that one,"
                " or change the option"
            )
        return probe

    def _require_fit(self, values: protocol.Record) -> None:
        require_stationary_pose(values)
        tip = tuple(values[name] for name in _TIP)
        if values["internal_probe_id"] != self._probe_id or self._tip not in (None, tip):
            self._prepared = False
            raise NotInitialisedError(
                "the tracker measured another probe or tip than before, so the measurements have a"
                " different frame: initialise it"
            )
        self._tip = tip

    async def _place_of(self, values: protocol.Record) -> Vector | None:
        """Where the prism is; the pose is of a frame or a tip elsewhere on the probe."""
        return await self._prism_mm()


def _probe_sentence(probe: protocol.Record) -> str:
    known = {int(kind): kind.name.replace("_", " ").lower() for kind in ProbeType}
    kind = known.get(probe.integer("probe_type"), "of a kind unknown here")
    return (
        f"The tracker measures the probe {probe.text('name')} ({kind}, serial"
        f" {probe.integer('serial_number')})."
    )


def _open(options: Options, clock: Clock) -> ProbeTracker:
    link = tcp_link(options, protocol.DEFAULT_PORT)
    return ProbeTracker(link, clock, probe=option.text(options, "probe"))


_OPTIONS = {
    "host": "address of the tracker controller, often 192.168.0.1",
    "port": f"TCP port, default {protocol.DEFAULT_PORT}",
    "probe": "name of the probe as stored in the tracker; default: the one that the beam is on",
}
PLUGIN = DriverPlugin("leica_emscon_6d", "pose_tracker", "emscon", _OPTIONS, _open)
