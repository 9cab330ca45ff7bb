"""What a monthly check of one robot asks: whether any of what ages in it has grown."""

from typing import Final

import numpy as np

from truepose.domain.errors import ConfigurationError
from truepose.fleet.causes import AgeingCause, robot_causes
from truepose.fleet.changes import Account
from truepose.fleet.pooled import of_robot_now
from truepose.fleet.quick_check import QuickCheck, quick_check
from truepose.planning.promise.knowledge import Knowns
from truepose.planning.work_volume.candidates import draw_candidates
from truepose.planning.work_volume.work_space import WorkSpace

GAP: Final = "backlash"
_SPRING: Final = "compliance"
_GEAR_LINES: Final = 10.0  # periods per turn from which a wave is a gear's
_CANDIDATES: Final = 300


def asked_of(account: Account) -> tuple[AgeingCause, ...]:
    """Return what ages: the springs and the lines of the gears, and whatever was named of a robot.

    A gap is none of them: configurations that are approached from one side never show it.

    Raises
    ------
    ConfigurationError
        The campaigns tell of nothing that ages.
    """
    named = {
        one.change.cause.key
        for one in account.named
        if one.change.scope == "robot" and one.change.cause.effect != GAP
    }
    asked = tuple(
        cause
        for cause in robot_causes(account.fleet)
        if cause.effect == _SPRING or cause.order > _GEAR_LINES or cause.key in named
    )
    if not asked:
        raise ConfigurationError(
            "A check asks what ages in a robot, and this fleet has neither a spring nor a line of a gear nor "
            "a change of a robot: compare campaigns that are identified with such effects."
        )
    return asked


def check_of(
    account: Account, robot: str, space: WorkSpace, knowns: Knowns, grown_mm: float, seed: int = 0
) -> QuickCheck:
    """Choose the configurations that tell whether a robot's causes have grown.

    Parameters
    ----------
    account : Account
    robot : str
    space : WorkSpace
        As it was measured last.
    knowns : Knowns
    grown_mm : float
    seed : int

    Raises
    ------
    ConfigurationError
        The growth is not above 0, or nothing ages.
    WorkSpaceError, TooFewCandidatesError
        As `draw_candidates`.
    """
    candidates = draw_candidates(space, _CANDIDATES, np.random.default_rng(seed))
    belief = of_robot_now(account, robot)
    return quick_check(space, candidates, belief, asked_of(account), grown_mm, knowns)
