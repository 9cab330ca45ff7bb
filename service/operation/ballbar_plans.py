"""Plans of ballbar sessions: what is wanted of one, and whether this cell and this kit can do it."""

from dataclasses import dataclass

from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan
from service.domain.robot import FramePlacement
from service.operation.errors import NoBallbarError
from service.storage.records import SessionSetup


@dataclass(frozen=True, slots=True)
class BallbarWish:
    """What is wanted of a ballbar session."""

    given: BallbarPlan | None = None  # None: poses, or placements too, are chosen
    frames: tuple[FramePlacement, ...] = ()  # of the base fixture; none: suggested
    placements: int = 1  # how many are suggested
    poses: int = 24  # of the whole session
    seed: int = 0


def kit_of(setup: SessionSetup) -> BallbarKit:
    """Return the kit of a cell; raises NoBallbarError."""
    if setup.cell.ballbar is None:
        raise NoBallbarError(
            f"The cell file of {setup.cell.name} describes no ballbar; give it a [ballbar] section."
        )
    return setup.cell.ballbar
