"""The cell of a tracker session: its devices, where things nominally are, and the arm at rest."""

from dataclasses import dataclass, field

from truepose.domain.cell import Camera, CertifiedLength
from truepose.domain.robot import FixedNest, FramePlacement, Nest
from truepose.domain.session import Vector
from truepose.sessions.engine.arm import ArmCell
from truepose.sessions.engine.ledger import Expected
from truepose_drivers.api import FullPoseTracker, FullTracker, JointReading


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionCell(ArmCell):
    """Devices, nominal robot and artefacts of one cell.

    The tracker's frame is unknown at first. Its fixed nests are found either from
    `fixed_nests_seen_mm` (somebody aimed at each once; good to about 20 mm) or, where only
    `tracker_position_mm` is known, by a search around the instrument's vertical axis.
    """

    tracker: FullTracker | FullPoseTracker  # of poses where the cell has a camera
    base: FramePlacement  # nominal, in the world
    nests: tuple[Nest, ...]  # tool nests, all with a centre
    fixed_nests: tuple[FixedNest, ...]
    tracker_position_mm: Vector | None = None  # nominal, in the world
    fixed_nests_seen_mm: tuple[Vector, ...] | None = None  # in the tracker's frame, roughly
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
