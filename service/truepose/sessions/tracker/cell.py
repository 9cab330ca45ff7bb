"""The cell of a tracker session: its devices, where things nominally are, and the arm at rest."""

from dataclasses import dataclass, field

from truepose.domain.cell import Camera, CertifiedLength
from truepose.domain.robot import FixedNest, FramePlacement, JointRange, Nest, Robot
from truepose.domain.session import Vector
from truepose.sessions.engine.ledger import Expected
from truepose.sessions.engine.ways import LookAtWays
from truepose_drivers.api import Clock, FullPoseTracker, FullRobot, FullTracker, JointReading, MotionLimits


@dataclass(frozen=True, slots=True)
class SessionCell:
    """Devices, nominal robot and artefacts of one cell.

    The tracker's frame is unknown at first. Its fixed nests are found either from
    `fixed_nests_seen_mm` (somebody aimed at each once; good to about 20 mm) or, where only
    `tracker_position_mm` is known, by a search around the instrument's vertical axis.
    """

    tracker: FullTracker | FullPoseTracker  # of poses where the cell has a camera
    robot_controller: FullRobot
    clock: Clock
    robot: Robot
    base: FramePlacement  # nominal, in the world
    nests: tuple[Nest, ...]  # tool nests, all with a centre
    fixed_nests: tuple[FixedNest, ...]
    look_at_ways: LookAtWays  # before the arm goes them
    tracker_position_mm: Vector | None = None  # nominal, in the world
    fixed_nests_seen_mm: tuple[Vector, ...] | None = None  # in the tracker's frame, roughly
    joint_limits: tuple[JointRange, ...] | None = None  # what no motion may leave
    speed_limits: MotionLimits | None = None  # above which nothing moves, whatever the plan says
    certified_lengths: tuple[CertifiedLength, ...] = ()  # between fixed nests: they verify the scale
    attachment: int = 1  # how often the tool has been mounted
    expected: Expected = field(default_factory=Expected)  # which devices must answer
    camera: Camera | None = None  # None: the tracker measures points
    first_pass: bool = False  # no session of this robot has finished yet


@dataclass(frozen=True, slots=True)
class AtRest:
    """Where the joints were read, and which way each of them came there."""

    joints: JointReading
    direction: tuple[int, ...]
