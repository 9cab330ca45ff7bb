"""What a driver offers: one small Protocol per kind of device, reading types, and the plugin that opens it.

Units: mm, rad, s, °C. Every reading carries the time of the cell's clock at which it was taken.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol, TypeAlias

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]  # w x y z
Options: TypeAlias = Mapping[str, str | int | float | bool]
DeviceKind: TypeAlias = Literal[
    "tracker", "robot", "clock", "ballbar", "hands", "pose_tracker", "linear_gauge"
]


@dataclass(frozen=True, slots=True)
class DeviceIdentity:
    """Who the device says it is."""

    manufacturer: str
    model: str
    serial: str
    firmware: str


@dataclass(frozen=True, slots=True)
class TrackerReading:
    """One stationary measurement, in the tracker's own frame."""

    point_mm: Vector
    standard_deviation_mm: Vector  # of the mean, as the instrument states it; NaN where it does not
    rms_mm: float  # total scatter of the samples
    samples: int
    duration_s: float
    face: Literal[1, 2]
    time_s: float  # cell clock, at the end of the measurement
    # Of the point, from the instrument's accuracy model (tracker frame); None where it states none.
    covariance_mm2: tuple[Vector, Vector, Vector] | None = None


@dataclass(frozen=True, slots=True)
class PoseReading:
    """Where an artefact stood, mean of the frames of a time, in the instrument's own frame."""

    quaternion: Quaternion  # unit; turns directions of the artefact's frame into the instrument's
    position_mm: Vector  # of the artefact's origin
    position_deviation_mm: Vector  # of one frame, per coordinate; NaN where there is one frame only
    rotation_deviation_rad: float  # of one frame, root mean square; NaN as above
    rms_mm: float  # of the fit of the artefact's markers, as the instrument states it
    frames: int  # that showed the artefact
    duration_s: float
    time_s: float  # cell clock, at the end of the measurement


@dataclass(frozen=True, slots=True)
class Environment:
    """Air as the instrument's weather station sees it."""

    temperature_c: float
    pressure_hpa: float
    humidity_percent: float


@dataclass(frozen=True, slots=True)
class JointReading:
    """Joint angles as the controller reports them."""

    joints_rad: tuple[float, ...]
    resolution_rad: float  # of the protocol, not of the encoder
    time_s: float  # cell clock, when the answer arrived


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Upper limits of a motion between configurations."""

    tool_speed_mm_s: float = 500.0
    orientation_speed_rad_s: float = 0.349  # 20 deg/s, thesis section 2.4


@dataclass(frozen=True, slots=True)
class MotionGuard:
    """What becomes of a motion under way when this program is gone or somebody asks for a pause.

    The default is the worst: the arm goes on to the target that was sent last.
    """

    stops_unheard_s: float | None = None  # silence after which the controller stops by itself; None: never
    longest_piece_s: float | None = None  # send no motion that takes longer at once; None: send it whole
    # Of the limits, as the controller's speed override leaves it now; None: the controller does not tell.
    speed_share: float | None = None
    speed_read_back: bool = False  # the controller states the limits that it was given
    speed_point_mm: Vector = (0.0, 0.0, 0.0)  # at which it keeps the tool's speed, in the flange's frame
    # From joints to joints [rad], at the limits that were set last and an override of 100 %; None: no longer
    # than they let it.
    takes_s: Callable[[tuple[float, ...], tuple[float, ...]], float] | None = field(
        default=None, compare=False
    )


@dataclass(frozen=True, slots=True)
class BallbarReading:
    """What a ballbar or length gauge shows now."""

    deviation_mm: float  # longer is positive; counted from the device's own zero; NaN without a signal
    signal: Literal["good", "out_of_range", "none"]
    resolution_mm: float  # of the protocol
    time_s: float  # cell clock, when the answer arrived
    temperature_c: float | None = None  # None where the device has no thermometer
    sequence: int | None = None  # the device's own count of its readings; None where it has none


class Clock(Protocol):
    """The clock of the cell: real cells use the monotonic clock, simulated ones offer their own."""

    async def now_s(self) -> float:
        """Return the present cell time [s]."""
        ...

    async def sleep(self, duration_s: float) -> None:
        """Let the cell's time advance by `duration_s`."""
        ...


class Device(Protocol):
    """What every device can do."""

    async def connect(self) -> None:
        """Open the link; raises ConnectFailedError."""
        ...

    async def close(self) -> None:
        """Close the link; never raises."""
        ...

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        ...

    async def identify(self) -> DeviceIdentity:
        """Ask the device who it is."""
        ...


class PointTracker(Device, Protocol):
    """An instrument that measures the centre of a reflector in its own frame."""

    async def initialise(self) -> None:
        """Bring the instrument into a state in which it can measure (units, mode, warm-up)."""
        ...

    async def find_reflector(self, near_mm: Vector, *, search_radius_mm: float) -> None:
        """Point at `near_mm` (tracker frame), lock on the reflector there; raises ReflectorNotFoundError."""
        ...

    async def measure_point(self, *, duration_s: float) -> TrackerReading:
        """Measure the reflector locked on; raises BeamBrokenError."""
        ...

    async def change_face(self) -> None:
        """Turn to the other face of the instrument, which stays locked on the same reflector."""
        ...

    async def environment(self) -> Environment:
        """Read the weather station."""
        ...


class PoseTracker(Device, Protocol):
    """An instrument that measures position and orientation of an artefact in its own frame."""

    async def initialise(self) -> None:
        """Load what the instrument must know of the artefact, and begin to follow it."""
        ...

    async def measure_pose(self, *, duration_s: float) -> PoseReading:
        """Measure the artefact at rest; raises ArtefactNotSeenError, OutOfVolumeError."""
        ...


class RobotController(Device, Protocol):
    """A robot that moves to joint targets."""

    @property
    def can_stop_motion(self) -> bool:
        """Whether a motion under way can be interrupted through this protocol."""
        ...

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed limits of the following motions, and stop exactly at every target."""
        ...

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there. Raises TargetRefusedError."""
        ...

    async def read_joints(self) -> JointReading:
        """Ask where the joints are."""
        ...


class Ballbar(Device, Protocol):
    """A telescoping ballbar, or any gauge that measures the length between two balls."""

    async def read(self) -> BallbarReading:
        """Return the newest reading; an unplugged device raises a LinkError."""
        ...


class LinearGauge(Device, Protocol):
    """A length gauge on its own, whose plunger touches something; a box of several is one device."""

    async def read(self) -> BallbarReading:
        """Return what the gauge shows, of several the first one.

        `deviation_mm` grows as the plunger is pushed in, and is counted from the gauge's own zero.
        """
        ...


class ReadsChannels(Protocol):
    """A box of several gauges, each of them as a LinearGauge."""

    async def read_channels(self) -> tuple[BallbarReading, ...]:
        """Return what all gauges show, in the order in which the cell file names their channels."""
        ...


class SimulatedHands(Device, Protocol):
    """The person at a simulated cell: what the service's demonstrations and tests have it do."""

    async def do(self, action: str, details: Options) -> None:
        """Do one thing, e.g. `connect` with `base` and `tool`; raises DeviceRefusedError."""
        ...


class GuardsMotion(Protocol):
    """A robot's driver that says more about its motions than it must."""

    @property
    def motion_guard(self) -> MotionGuard:
        """As far as known; before the controller has said who it is, the worst of what it may be."""
        ...


class StatesSettings(Protocol):
    """An instrument whose driver says what it measures with, for the record of whoever uses its readings."""

    @property
    def settings(self) -> str:
        """One sentence, as the instrument confirmed it when it was last initialised; empty before that."""
        ...


class ShowsReflector(Protocol):
    """A tracker that says where the reflector is while it measures nothing."""

    async def reflector_now(self) -> Vector | None:
        """Return one sample of where the reflector is (tracker frame), None where none is locked on.

        It is for people who look on, and has the noise of a single sample; nothing is measured by it.
        """
        ...


AnyDevice: TypeAlias = (
    PointTracker | PoseTracker | RobotController | Clock | Ballbar | LinearGauge | SimulatedHands
)


class FullTracker(PointTracker, StatesSettings, ShowsReflector, Protocol):
    """A tracker as the service gets it: its guard answers for an ability that the driver lacks."""


class FullPoseTracker(PoseTracker, StatesSettings, Protocol):
    """A tracker of poses as the service gets it."""


class FullRobot(RobotController, GuardsMotion, Protocol):
    """A robot as the service gets it: whatever is put around it says what becomes of a motion."""


class FullGauge(LinearGauge, ReadsChannels, Protocol):
    """A box of gauges as the service gets it; a gauge alone is a box of one."""


class FullClock(Clock, Protocol):
    """A clock as the service gets it."""

    async def close(self) -> None:
        """Close the clock's connections where it has any; never raises."""
        ...


AnyGuarded: TypeAlias = (
    FullTracker | FullPoseTracker | FullRobot | FullClock | Ballbar | FullGauge | SimulatedHands
)


@dataclass(frozen=True, slots=True)
class DriverPlugin:
    """A registered driver: its configuration name, what it drives, and how to open it.

    `open` takes the options of the cell file (host, port, ...) and the clock that stamps its readings; it
    connects nothing. What it returns must do for its `kind` and for every one in `also`.
    """

    name: str
    kind: DeviceKind
    protocol: str
    options: Mapping[str, str]  # option -> one sentence, for the cell file's reader
    open: "OpenDriver"
    also: tuple[DeviceKind, ...] = ()  # what else the cell file may use the device as


class OpenDriver(Protocol):
    """Builds a driver from its options; connects nothing."""

    def __call__(self, options: Options, clock: Clock) -> AnyDevice:
        """Return the driver; raises ConfigurationError for an option that is missing or wrong."""
        ...
