"""Which of several nominal robots readings are of, and by which changes of convention.

A robot fits where the median residual of its nominal table, placed best (`problem.placement`), is below what
is plausible for its size (`verdict.conventions`). As it is, with one change, with two, then with another zero
of one joint: the first of these that fits is the answer. Between robots the share of what is plausible
decides.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from truepose.domain.robot import Robot
from truepose.identification.problem.initial_frames import PriorPlacement, place
from truepose.identification.verdict.conventions import (
    Change,
    Evidence,
    Interpretation,
    change_that_fits,
    changes,
    may_leave,
    plausible_mm,
    thin_readings,
    typical_mm,
)
from truepose.kinematics.chain import nominal_chain

_SHORT_LIST = 3  # single changes after which a second one is looked for


@dataclass(frozen=True, slots=True)
class Match:
    """A robot held against readings.

    Attributes
    ----------
    robot : Robot
        As it was given.
    changes : tuple of Change
        That readings or table need for it.
    typical_mm : float
        Median residual of the nominal robot, after them.
    """

    robot: Robot
    changes: tuple[Change, ...]
    typical_mm: float

    @property
    def fits(self) -> bool:
        """Whether a nominal robot of this size may leave so much."""
        return self.typical_mm < plausible_mm(self.robot)


def match(robot: Robot, evidence: Evidence, known: PriorPlacement, *, search_zeros: bool = True) -> Match:
    """Hold a robot against readings: as it is, else with the one or two changes that make it fit.

    Parameters
    ----------
    robot : Robot
        Of as many joints as the readings.
    evidence : Evidence
    known : PriorPlacement
        Of base and nests; the base is searched for anew.
    search_zeros : bool
        Whether a joint may count from another angle: ten times the work of all other changes.

    Returns
    -------
    Match
        Without changes where none helps.
    """
    free = replace(known, base=None)
    meant = Interpretation(robot, thin_readings(evidence))
    as_it_is = _unchanged(meant, free)
    if as_it_is.fits:
        return as_it_is
    singles = sorted((_with(meant, free, one) for one in changes(meant, known)), key=_typical)
    # Two mistakes at once, a unit and a sign, leave neither alone plausible; one is still among the best.
    pairs = _pairs(meant, free, singles[:_SHORT_LIST])
    for found in (singles[0], min(pairs, key=_typical, default=as_it_is)):
        if found.fits:
            return found
    zero = change_that_fits(robot, evidence, known) if search_zeros else None
    return as_it_is if zero is None else _with(meant, free, zero)


def _unchanged(meant: Interpretation, known: PriorPlacement) -> Match:
    """Return a robot held against readings as it is; a few gross ones do not make it look like another."""
    quick = Match(meant.robot, (), typical_mm(meant, known))
    if quick.fits:
        return quick
    evidence = meant.evidence
    chain = nominal_chain(meant.robot, evidence.joints_rad)
    # Least squares without weights is quick, and a few readings far off spoil it: asked once more, robustly.
    return Match(meant.robot, (), place(chain, evidence.nest, evidence.position_mm, known).typical_mm)


def _typical(one: Match) -> float:
    return one.typical_mm


def _with(meant: Interpretation, known: PriorPlacement, change: Change) -> Match:
    return Match(meant.robot, (change,), typical_mm(change.applied(meant), known))


def _pairs(meant: Interpretation, known: PriorPlacement, singles: Sequence[Match]) -> Iterator[Match]:
    """Yield what a second change adds to the most promising first ones, where the robot may fit then."""
    for single in singles:
        (first,) = single.changes
        once = first.applied(meant)
        for second in changes(meant, known):
            if second == first:
                continue
            twice = second.applied(once)
            if may_leave(twice, known, plausible_mm(meant.robot)):
                yield Match(meant.robot, (first, second), typical_mm(twice, known))


def matches(robots: Sequence[Robot], evidence: Evidence, known: PriorPlacement) -> tuple[Match, ...]:
    """Return how robots of as many joints fit, the best first.

    One that fits as it is goes before all that need a change; then those with fewer changes go first.

    Parameters
    ----------
    robots : sequence of Robot
        Those of another number of joints are passed over.
    evidence : Evidence
    known : PriorPlacement
        Of base and nests; the base is searched for anew.
    """
    able = [robot for robot in robots if robot.n_joints == evidence.joints_rad.shape[1]]
    free = replace(known, base=None)
    plain = [_unchanged(Interpretation(robot, thin_readings(evidence)), free) for robot in able]
    fitting = [one for one in plain if one.fits]
    # Of many robots zeros are not searched for: that would be ten times the work for each of them.
    found = fitting or [match(robot, evidence, known, search_zeros=len(able) == 1) for robot in able]
    # By shares of what is plausible: a large robot may leave more millimetres than a small one.
    return tuple(sorted(found, key=lambda one: (not one.fits, len(one.changes), _share(one))))


def _share(one: Match) -> float:
    return one.typical_mm / plausible_mm(one.robot)
