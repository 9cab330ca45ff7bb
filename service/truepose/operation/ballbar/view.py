"""A ballbar session as those see it who ask."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.operation.ballbar.plans import kit_of
from truepose.sequencing.ballbar.situation import Situation
from truepose.storage.records import SessionSetup

if TYPE_CHECKING:
    from truepose.operation.ballbar.early_judges import Sight


@dataclass(frozen=True, slots=True)
class BallbarView:
    """A ballbar session as it stands now."""

    id: int
    name: str
    setup: SessionSetup
    plan: BallbarPlan
    situation: Situation
    newest_entry: int | None
    sight: "Sight"
    watching: int  # tablets that follow it
    question: str | None = None
    prompt_id: int | None = None  # of the question
    robot_moving: bool = False
    trouble: str | None = None  # why the session waits for the disk
    motion_notice: str | None = None  # what whoever lets the arm move has to know of its controller
    people: tuple[str, ...] = ()  # who may have the arm move; empty: whoever gives a name

    @property
    def kit(self) -> BallbarKit:
        """What the ballbar comes with."""
        return kit_of(self.setup)


@dataclass(frozen=True, slots=True)
class Fixed:
    """What of a session never changes."""

    name: str
    setup: SessionSetup
    plan: BallbarPlan
    sight: "Sight"


def sight_of(setup: SessionSetup, plan: BallbarPlan) -> "Sight":
    """Return what can be said of lengths before anything is calibrated; takes a while."""
    from truepose.operation.ballbar.early_judges import Sight  # numerics: a start does not wait for them

    return Sight(setup, plan, kit_of(setup))
