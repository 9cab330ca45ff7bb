"""A Leica laser tracker with a probe of six degrees of freedom (T-Mac, T-Probe): stationary poses of it."""

import contextlib
import math

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DriverPlugin, Options, PoseReading, Vector
from truepose_drivers.errors import DeviceRefusedError, NotInitialisedError
from truepose_drivers.leica_emscon.conversation import Subject
from truepose_drivers.leica_emscon.instrument import EmsconInstrument, TimeOuts
from truepose_drivers.leica_emscon.pose import require_stationary_pose, unit_quaternion
from truepose_drivers.leica_emscon.protocol import DEFAULT_PORT, Command, PacketType, Record, Value
from truepose_drivers.leica_emscon.protocol.equipment import ProbeType
from truepose_drivers.leica_emscon.protocol.settings import MeasMode, SystemParameter
from truepose_drivers.leica_emscon.sentences import CommandUnknownError
from truepose_drivers.leica_emscon.settled import COMPENSATION, Setting, mode
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import tcp_link

_POSES = Subject(frozenset({PacketType.STATIONARY_PROBE_MEAS_RESULT}), "measure_pose")
_TIP = ("internal_tip_adapter_id", "tip_adapter_interface")
# A pose depends on all of them; which they are is the business of the tracker's own program.
_COMPENSATIONS = (
    COMPENSATION,
    Setting(
        "compensation of its camera",
        Command.GET_T_CAM_TO_TRACKER_COMPENSATION,
        kept=("internal_t_cam_to_tracker_compensation_id",),
    ),
    Setting(
        "compensation of the probe", Command.GET_PROBE_COMPENSATION, kept=("internal_probe_compensation_id",)
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
        self._probe_id: Value | None = None
        self._tip: tuple[Value, ...] | None = None  # that was measured since initialising; none is one too

    async def initialise(self) -> None:
        """Set units, mode and frame, and see which probe is there; start up the tracker where needed.

        Raises NotInitialisedError when it does not come up, DeviceRefusedError when it cannot measure poses,
        sees no probe, or another than the one that is asked for.
        """
        try:
            await self._prepare(Record(meas_mode=MeasMode.STATIONARY_6D))
        except CommandUnknownError as error:
            raise DeviceRefusedError(
                f"this tracker measures points and no poses ({error}): use the driver leica_emscon"
            ) from error
        await self._catch_the_beam_again()
        probe = await self._present_probe()
        self._tip = None
        self._probe_id = probe["internal_probe_id"]
        number = Record(internal_probe_id=self._probe_id)
        await self._settle(
            _probe_sentence(probe),
            mode(MeasMode.STATIONARY_6D),
            Setting("probe", Command.GET_PROBE, number),
            *_COMPENSATIONS,
        )

    async def measure_pose(self, *, duration_s: float) -> PoseReading:
        """Average over `duration_s`; raises ArtefactNotSeenError, OutOfVolumeError."""
        await self._require_prepared()
        values = await self._measured(duration_s)
        return PoseReading(
            quaternion=unit_quaternion(values),
            position_mm=values.vector("position1", "position2", "position3"),
            position_deviation_mm=values.vector(
                "std_dev_position1", "std_dev_position2", "std_dev_position3"
            ),
            rotation_deviation_rad=values.number("std_dev_rotation_angle_total"),
            rms_mm=math.nan,  # emScon judges the fit of the lamps by itself, and states no figure
            frames=1,  # it averages inside and does not say over how many
            duration_s=duration_s,
            time_s=await self._clock.now_s(),
        )

    async def _catch_the_beam_again(self) -> None:
        """Have the tracker find a probe that was hidden, where it can."""
        power_lock = Record(system_param=SystemParameter.POWER_LOCK_FUNCTION_ACTIVE, parameter=1)
        with contextlib.suppress(DeviceRefusedError):
            await self._ask(Command.SET_LONG_SYSTEM_PARAMETER, power_lock)

    async def _present_probe(self) -> Record:
        """Return the probe that the beam is on, by the tracker's list."""
        present = (await self._ask(Command.GET_PROBE))["internal_probe_id"]
        known = await self._conversation.ask_list(Command.GET_PROBES, timeout_s=self._time_outs.command_s)
        for probe in known:
            if probe["internal_probe_id"] == present:
                return self._required(probe)
        raise DeviceRefusedError("the tracker sees no probe that it knows: lead the beam to the probe")

    def _required(self, probe: Record) -> Record:
        name = probe.text("name")
        if self._wanted not in (None, name):
            raise DeviceRefusedError(
                f"the tracker sees the probe {name!r}, option probe names {self._wanted!r}: mount that one,"
                " or change the option"
            )
        return probe

    def _require_fit(self, values: Record) -> None:
        require_stationary_pose(values)
        tip = tuple(values[name] for name in _TIP)
        if values["internal_probe_id"] != self._probe_id or self._tip not in (None, tip):
            self._prepared = False
            raise NotInitialisedError(
                "the tracker measured another probe or tip than before, which is another frame: initialise it"
            )
        self._tip = tip

    async def _place_of(self, values: Record) -> Vector | None:
        """Where the prism is; the pose is of a frame or a tip elsewhere on the probe."""
        return await self._prism_mm()


def _probe_sentence(probe: Record) -> str:
    known = {int(kind): kind.name.replace("_", " ").lower() for kind in ProbeType}
    kind = known.get(probe.integer("probe_type"), "of a kind unknown here")
    return (
        f"The tracker measures the probe {probe.text('name')} ({kind}, serial"
        f" {probe.integer('serial_number')})."
    )


def _open(options: Options, clock: Clock | None) -> ProbeTracker:
    link = tcp_link(options, DEFAULT_PORT)
    return ProbeTracker(link, clock or MonotonicClock(), probe=option.text(options, "probe"))


_OPTIONS = {
    "host": "address of the tracker controller, often 192.168.0.1",
    "port": f"TCP port, {DEFAULT_PORT} unless changed",
    "probe": "name of the probe as stored in the tracker; whichever the beam is on if left out",
}
PLUGIN = DriverPlugin("leica_emscon_6d", "pose_tracker", "emscon", _OPTIONS, _open)
