"""What can be seen of wrong connections in a ballbar session, and who judges its lengths."""

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import BallbarPlan, Leg, StepKind
from truepose.planning.ballbar.lengths.beforehand import known_beforehand
from truepose.planning.ballbar.lengths.unseen import unseen_swaps
from truepose.sequencing.ballbar.doubts.assignments import Judges
from truepose.sequencing.ballbar.doubts.early import EarlyJudge
from truepose.sequencing.ballbar.situation import Situation
from truepose.storage.records import SessionSetup


class Sight:
    """The judges of one session, and the swaps that they do not see."""

    def __init__(self, setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit) -> None:
        known = known_beforehand(setup.cell, plan, kit)
        self._early = None if known is None else EarlyJudge(known, kit)
        self._unseen = () if known is None else unseen_swaps(known, plan, kit)

    @property
    def judges(self) -> Judges:
        """Who judges the lengths of the session."""
        return Judges(early=self._early)

    def alike(self, now: Situation) -> tuple[tuple[Leg, Leg], ...]:
        """Return the pairs of legs of the present pose whose exchange would not show."""
        return () if self._early is None else self._early.alike(now)

    def sees_swaps(self, now: Situation) -> bool:
        """Whether an exchange of any two legs of the present pose shows, but for chance."""
        if self._early is None or now.step is None or now.step.kind is not StepKind.CONNECT_LEG:
            return now.forecast is not None
        return not self._early.alike(now)

    def unseen(self, now: Situation) -> tuple[int, ...]:
        """Return the poses ahead of which an exchange is hardly seen when it is made."""
        if any(now.outcomes[step.id].kind == "computed" for step in now.steps):
            return ()
        ahead = {
            step.config
            for step in now.steps
            if step.kind is StepKind.CONNECT_LEG and now.outcomes[step.id].kind == "open"
        }
        return tuple(config for config in self._unseen if config in ahead)
