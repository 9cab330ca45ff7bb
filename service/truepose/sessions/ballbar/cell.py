"""What a ballbar session knows of its cell, and who identifies with what is there halfway."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import TypeAlias

from truepose.domain.ballbar import BallbarPlan, PlannedPlacement, PreCalibration
from truepose.domain.cell import BallbarKit
from truepose.domain.errors import TrueposeError
from truepose.domain.ledger import LedgerEntry
from truepose.messages.message import Text, message
from truepose.planning.workspace.path_clearance import Ways
from truepose.sessions.ballbar.dry_run import check_pose
from truepose.sessions.engine.arm import ArmCell
from truepose.sessions.engine.ledger import Expected
from truepose_drivers.api import Ballbar

# At ways beside the base fixture of a placement; a cup (1-based) to which the tool goes is none of it.
LookPastFixture: TypeAlias = Callable[[PlannedPlacement, int | None, Ways], Awaitable[Text]]
# Identifies with what these lines say was measured; raises TrueposeError where that is impossible.
PreCalibrate: TypeAlias = Callable[[BallbarPlan, tuple[LedgerEntry, ...]], Awaitable[PreCalibration]]


@dataclass(frozen=True, slots=True, kw_only=True)
class BallbarCell(ArmCell):
    """Devices and nominal robot of one cell; `look_at_ways` is for the plan, which keeps off the fixture."""

    ballbar: Ballbar
    look_past_fixture: LookPastFixture  # at other ways
    expected: Expected = field(default_factory=Expected)  # which devices must answer
    ballbar_device_serial: str = ""  # of the device entry that the session was planned with


async def precalibrated(
    precalibrate: PreCalibrate, plan: BallbarPlan, kit: BallbarKit, entries: tuple[LedgerEntry, ...]
) -> PreCalibration | Text:
    """Return what was found, or the sentence that says why nothing was."""
    try:
        found = await precalibrate(plan, entries)
        for pose in found.poses:
            check_pose(pose, kit)
    except TrueposeError as error:
        return error.text
    except Exception as error:  # whatever it is, the readings are safe and a person decides
        return message("session.program_failed", kind=type(error).__name__, why=str(error))
    return found
