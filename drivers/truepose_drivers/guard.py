"""What stands between a driver, whoever wrote it, and the service.

- An exception that is none of a driver becomes a DriverFaultError with a sentence, and closes the link: what
  a driver left in the middle of a conversation must not be taken for the answer to the next question.
- Nonsense closes the link as well, where the driver has not done so.
- A reading is judged for what no instrument of its kind can mean, see `plausibility`, and a device's count of
  its readings for whether it goes on, see `standing_count`.
- What a driver offers beyond its kind (see `abilities`) goes the same way, and nothing else passes.

Whatever ends a task (CancelledError, KeyboardInterrupt) passes.
"""

import contextlib
import functools
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

from truepose_drivers import api, plausibility
from truepose_drivers.errors import (
    DriverError,
    DriverFaultError,
    ImplausibleReadingError,
    RemoteProtocolError,
)

Value = TypeVar("Value")
P = ParamSpec("P")
Guard = TypeVar("Guard", bound="GuardedDevice")


def _watched(
    ask: Callable[Concatenate[Guard, P], Awaitable[Value]],
) -> Callable[Concatenate[Guard, P], Coroutine[Any, Any, Value]]:
    """Name the driver in what a call of it raises, and close the link where it must not go on."""

    @functools.wraps(ask)
    async def ask_watched(self: Guard, /, *args: P.args, **kwargs: P.kwargs) -> Value:
        try:
            return await ask(self, *args, **kwargs)
        except ImplausibleReadingError as error:
            # Closed, since the next answer of a device in this state could be taken for that to another
            # question.
            await self.close()
            raise ImplausibleReadingError(f"device of driver {self._name}: {error}") from error
        except RemoteProtocolError:
            await self.close()
            raise
        except DriverError:
            raise
        except Exception as error:
            await self.close()
            raise fault_of(self._name, ask.__name__, error) from error

    return ask_watched


class GuardedDevice:
    """A device behind its driver's name."""

    def __init__(self, name: str, device: api.Device) -> None:
        self._name = name
        self._device = device
        self._last_s: float | None = None  # time stamp of the last reading of this connection

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known; no where the driver cannot tell."""
        try:
            # A property of somebody else's driver may do anything; where it fails, "no" is what is safe:
            # nothing moves without a link (docs/motion-rules.md, S1).
            return bool(self._device.connected)
        except Exception:
            return False

    @_watched
    async def connect(self) -> None:
        """Open the link; raises ConnectFailedError."""
        self._last_s = None
        # A clock that began anew while the link was down has not run back: order is asked within a connection
        # only.
        await self._device.connect()

    async def close(self) -> None:
        """Close the link; never raises, whatever the driver does."""
        with contextlib.suppress(Exception):
            await self._device.close()

    @_watched
    async def identify(self) -> api.DeviceIdentity:
        """Ask the device who it is."""
        return plausibility.readable(await self._device.identify())

    def _stamp(self, time_s: float) -> None:
        plausibility.require_time(time_s, self._last_s)
        self._last_s = time_s


class GuardedInstrument(GuardedDevice):
    """An instrument that is prepared before it measures."""

    _device: api.PointTracker | api.PoseTracker

    @property
    def settings(self) -> str:
        """What it measures with; empty where the driver cannot tell."""
        return plausibility.settings_of(self._device)

    @_watched
    async def initialise(self) -> None:
        """Bring the instrument into a state in which it can measure."""
        await self._device.initialise()


class GuardedTracker(GuardedInstrument):
    """A tracker whose readings are judged."""

    _device: api.PointTracker

    @_watched
    async def find_reflector(self, near_mm: api.Vector, *, search_radius_mm: float) -> None:
        """Lock on the reflector near a place of the tracker's frame; raises ReflectorNotFoundError."""
        await self._device.find_reflector(near_mm, search_radius_mm=search_radius_mm)

    @_watched
    async def measure_point(self, *, duration_s: float) -> api.TrackerReading:
        """Measure the reflector locked on; raises BeamBrokenError, ImplausibleReadingError."""
        reading = await self._device.measure_point(duration_s=duration_s)
        # Judged before its stamp is taken over: a reading that counts for nothing must not date the next
        # one.
        plausibility.require_point(reading)
        self._stamp(reading.time_s)
        return reading

    @_watched
    async def change_face(self) -> None:
        """Turn to the other face."""
        await self._device.change_face()

    @_watched
    async def reflector_now(self) -> api.Vector | None:
        """Return where the reflector is for people who look on; None also where the driver cannot tell."""
        offered = plausibility.reflector_of(self._device)
        return None if offered is None else plausibility.place_or_none(await offered())

    @_watched
    async def environment(self) -> api.Environment:
        """Read the weather station; raises ImplausibleReadingError."""
        air = await self._device.environment()
        plausibility.require_environment(air)
        return air


class GuardedPoseTracker(GuardedInstrument):
    """A tracker of poses whose readings are judged."""

    _device: api.PoseTracker

    @_watched
    async def measure_pose(self, *, duration_s: float) -> api.PoseReading:
        """Measure the artefact; raises ArtefactNotSeenError, OutOfVolumeError, ImplausibleReadingError."""
        reading = await self._device.measure_pose(duration_s=duration_s)
        plausibility.require_pose(reading)
        self._stamp(reading.time_s)
        return reading


class GuardedRobot(GuardedDevice):
    """A robot whose statements are judged."""

    _device: api.RobotController

    def __init__(self, name: str, device: api.RobotController) -> None:
        super().__init__(name, device)
        self._joints: int | None = None

    @property
    def can_stop_motion(self) -> bool:
        """Whether a motion under way can be interrupted; no where the driver cannot tell."""
        try:
            return bool(self._device.can_stop_motion)
        except Exception:
            return False

    @property
    def motion_guard(self) -> api.MotionGuard:
        """What becomes of a motion when this program is gone; the worst where the driver cannot tell."""
        return plausibility.motion_guard_of(self._device)

    @_watched
    async def set_limits(self, limits: api.MotionLimits) -> None:
        """Set the speed limits of the following motions."""
        await self._device.set_limits(limits)

    @_watched
    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints; raises TargetRefusedError."""
        await self._device.move_joints(target_rad)

    @_watched
    async def read_joints(self) -> api.JointReading:
        """Ask where the joints are; raises ImplausibleReadingError."""
        reading = await self._device.read_joints()
        plausibility.require_joints(reading, self._joints)
        self._stamp(reading.time_s)
        # An arm does not change its number of joints, not even over connections: another number is
        # another arm, or half a frame.
        self._joints = len(reading.joints_rad)
        return reading


class GuardedBallbar(GuardedDevice):
    """A ballbar whose readings are judged."""

    _device: api.Ballbar

    def __init__(self, name: str, device: api.Ballbar) -> None:
        super().__init__(name, device)
        self._count = plausibility.StandingCount()

    async def connect(self) -> None:
        """Open the link; raises ConnectFailedError."""
        self._count = plausibility.StandingCount()
        await super().connect()

    @_watched
    async def read(self) -> api.BallbarReading:
        """Return the newest reading; raises ImplausibleReadingError."""
        reading = await self._device.read()
        plausibility.require_length(reading)
        self._stamp(reading.time_s)
        self._count.require_going_on(reading)
        return reading


class GuardedGauge(GuardedDevice):
    """A box of linear gauges whose readings are judged; a gauge alone is a box of one."""

    _device: api.LinearGauge

    async def read(self) -> api.BallbarReading:
        """Return what the first gauge shows; raises ImplausibleReadingError."""
        return (await self.read_channels())[0]

    @_watched
    async def read_channels(self) -> tuple[api.BallbarReading, ...]:
        """Return what all gauges show; raises ImplausibleReadingError."""
        # One question for all gauges of a box, so that a length and its neighbours are of one moment.
        readings = await plausibility.channels_of(self._device)
        plausibility.require_some(readings)
        for reading in readings:
            plausibility.require_length(reading)
            self._stamp(reading.time_s)
        return readings


class GuardedHands(GuardedDevice):
    """The person at a simulated cell."""

    _device: api.SimulatedHands

    @_watched
    async def do(self, action: str, details: api.Options) -> None:
        """Do one thing; raises DeviceRefusedError."""
        await self._device.do(action, details)


class GuardedClock:
    """A clock that does not run backwards unnoticed."""

    def __init__(self, name: str, clock: api.Clock) -> None:
        self._name = name
        self._clock = clock
        self._latest_s: float | None = None

    async def now_s(self) -> float:
        """Return the present cell time [s]; raises ImplausibleReadingError once where it went back."""
        before_s = self._latest_s  # several tasks ask at once, and their answers may overtake each other
        try:
            now_s = float(await self._clock.now_s())
            self._latest_s = None  # a clock that began anew is told of once
            plausibility.require_time(now_s, before_s)
        except DriverError:
            self._latest_s = None
            raise
        except Exception as error:
            self._latest_s = None
            raise fault_of(self._name, "now_s", error) from error
        self._latest_s = now_s if before_s is None else max(before_s, now_s)
        return now_s

    async def sleep(self, duration_s: float) -> None:
        """Let the cell's time advance."""
        try:
            await self._clock.sleep(duration_s)
        except DriverError:
            raise
        except Exception as error:
            raise fault_of(self._name, "sleep", error) from error

    async def close(self) -> None:
        """Close the clock's connections where it has any; never raises."""
        with contextlib.suppress(Exception):
            await cast(api.FullClock, self._clock).close()  # one that has none raises, too


def guarded(name: str, kind: api.DeviceKind, device: api.AnyDevice) -> api.AnyGuarded:
    """Return a device of driver `name` behind its guard."""
    match kind:
        case "tracker":
            return GuardedTracker(name, cast(api.PointTracker, device))
        case "pose_tracker":
            return GuardedPoseTracker(name, cast(api.PoseTracker, device))
        case "robot":
            return GuardedRobot(name, cast(api.RobotController, device))
        case "ballbar":
            return GuardedBallbar(name, cast(api.Ballbar, device))
        case "linear_gauge":
            return GuardedGauge(name, cast(api.LinearGauge, device))
        case "hands":
            return GuardedHands(name, cast(api.SimulatedHands, device))
        case "clock":
            return GuardedClock(name, cast(api.Clock, device))


def fault_of(name: str, what: str, error: Exception) -> DriverFaultError:
    """Return what a foreign exception becomes, with a sentence for the operator."""
    return DriverFaultError(
        f"driver {name} failed in {what} ({type(error).__name__}: {str(error)[:200]}): check the device's"
        " cable and power, then connect again; if it happens again, report it to the supplier of the driver"
    )
