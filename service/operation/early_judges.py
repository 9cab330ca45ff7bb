"""Who judges the lengths of a ballbar session before its pre-calibration, and what it cannot see."""

from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan
from service.domain.errors import ConfigurationError
from service.planning.ballbar.beforehand import Beforehand
from service.planning.ballbar.plan import ballbar_cell
from service.planning.errors import WorkSpaceError
from service.sequencing.ballbar.early import EarlyJudge
from service.storage.records import SessionSetup


def early_judge(setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit) -> EarlyJudge | None:
    """Return the judge of a session; None where too little is known of robot, tool or cups."""
    known = known_beforehand(setup, plan, kit)
    return None if known is None else EarlyJudge(known, kit)


def known_beforehand(setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit) -> Beforehand | None:
    """Return what is known of the lengths of a plan; None where that is too little."""
    if not all(placement.setups for placement in plan.placements):
        return None
    try:
        return Beforehand(ballbar_cell(setup.cell), plan, kit)
    except (ConfigurationError, WorkSpaceError):
        return None
