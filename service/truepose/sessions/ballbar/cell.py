"""What a ballbar session knows of its cell, and who identifies with what is there halfway."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

from truepose.domain.ballbar import BallbarPlan, PlannedPlacement, PreCalibration
from truepose.domain.cell import BallbarKit
from truepose.domain.errors import TrueposeError
from truepose.domain.ledger import LedgerEntry
from truepose.domain.robot import JointRange, Robot
from truepose.messages.message import Text, message
from truepose.planning.workspace.path_clearance import Ways
from truepose.sessions.ballbar.dry_run import check_pose
from truepose.sessions.engine.ledger import Expected
from truepose.sessions.engine.ways import LookAtWays
from truepose_drivers.api import Ballbar, Clock, FullRobot, MotionLimits

# At ways beside the base fixture of a placement; a cup (1-based) to which the tool goes is none of it.
LookPastFixture: TypeAlias = Callable[[PlannedPlacement, int | None, Ways], Awaitable[Text]]


@dataclass(frozen=True, slots=True)
class BallbarCell:
    """Devices and nominal robot of one cell."""

    ballbar: Ballbar
    robot_controller: FullRobot
    clock: Clock
    robot: Robot
    look_at_ways: LookAtWays  # of the plan, which keeps off the base fixture
    look_past_fixture: LookPastFixture  # at others
    joint_limits: tuple[JointRange, ...] | None = None  # what no motion may leave
    speed_limits: MotionLimits | None = None  # above which nothing moves, whatever the plan says
    expected: Expected = field(default_factory=Expected)  # which devices must answer
    ballbar_device_serial: str = ""  # of the device entry that the session was planned with


class PreCalibrator(Protocol):
    """Computes where to aim and which lengths to expect there."""

    async def precalibrate(self, plan: BallbarPlan, entries: tuple[LedgerEntry, ...]) -> PreCalibration:
        """Identify with what these lines say was measured; raises TrueposeError where that is impossible."""
        ...


async def precalibrated(
    precalibrator: PreCalibrator, plan: BallbarPlan, kit: BallbarKit, entries: tuple[LedgerEntry, ...]
) -> PreCalibration | Text:
    """Return what was found, or the sentence that says why nothing was."""
    try:
        found = await precalibrator.precalibrate(plan, entries)
        for pose in found.poses:
            check_pose(pose, kit)
    except TrueposeError as error:
        return error.text
    except Exception as error:  # whatever it is, the readings are safe and a person decides
        return message("session.program_failed", kind=type(error).__name__, why=str(error))
    return found
