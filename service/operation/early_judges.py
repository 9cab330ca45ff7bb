"""Who judges the lengths of a ballbar session before its pre-calibration."""

from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan
from service.planning.ballbar.beforehand import known_beforehand
from service.sequencing.ballbar.early import EarlyJudge
from service.storage.records import SessionSetup


def early_judge(setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit) -> EarlyJudge | None:
    """Return the judge of a session; None where too little is known of robot, tool or cups."""
    known = known_beforehand(setup.cell, plan, kit)
    return None if known is None else EarlyJudge(known, kit)
