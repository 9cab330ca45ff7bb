"""A ballbar session as those see it who ask."""

from dataclasses import dataclass

from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan
from service.operation.ballbar_plans import kit_of
from service.operation.early_judges import Sight
from service.sequencing.ballbar.situation import Situation
from service.storage.records import SessionSetup


@dataclass(frozen=True, slots=True)
class BallbarView:
    """A ballbar session as it stands now."""

    id: int
    name: str
    setup: SessionSetup
    plan: BallbarPlan
    situation: Situation
    question: str | None
    newest_entry: int | None
    robot_moving: bool
    sight: Sight
    watching: int  # tablets that follow it
    trouble: str | None = None  # why the session waits for the disk
    motion_notice: str | None = None  # what whoever lets the arm move has to know of its controller

    @property
    def kit(self) -> BallbarKit:
        """What the ballbar comes with."""
        return kit_of(self.setup)
