"""What is known of the lengths of a session before it is measured, and which exchanges would go unseen.

Unknown are geometry and compliances of the arm, the nests of the tool, and the cups. A cup is clamped where
the arm holds the ball, so the arm's errors there move the cup as well: in a length is left what they differ
by between set-up and pose, and the base plays no part.

How exact an arm is, nobody knows beforehand. So there are several kinds, which differ by the errors of their
links and by what moves the tool from stop to stop and is in no model: waves of the gears, play, bending. The
sizes are those of small robots as made (A. Nubiola, thesis, ETS Montreal 2014, chapters 2 and 4), and of such
that were repaired.

*Exchanges.* All legs of a planned pose are nominally of one length. What tells them apart is the errors of
the arm, and these show only as far as the poses before have told of them: that follows from the plan alone.

With x the unknowns, normally distributed about m with covariance V for each kind of arm, lengths are l + A x.
A cup is where nest 1 was at its set-up, c = S x_arm + noise, so that V has the blocks V_arm, S V_arm and S
V_arm S' + n^2 I. An exchange of two legs a, b shows where they differ by t = `TOLD_APART` times what the
poses before leave unsure of the difference:

    P = erfc(t u / (d sqrt(2)))        u^2 = var of the difference after those poses,  d^2 = before any
"""

from itertools import combinations, product
from math import erfc, sqrt
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import TOLD_APART, ArmKind, BallbarPlan, Leg, PlannedPose, StopLengths
from truepose.domain.cell import BallbarKit, Cell
from truepose.domain.errors import ConfigurationError
from truepose.kinematics.frames import cross_matrix, directions
from truepose.planning.ballbar.arm_model import arm_model
from truepose.planning.ballbar.bodies import BallbarCell, chain_of
from truepose.planning.ballbar.plan import ballbar_cell
from truepose.planning.errors import WorkSpaceError

_LEVER_MM: Final = 100.0  # at which a turn of the tool is counted as a shift
_LINK_MM: Final = 0.2  # standard deviation of a length of a link
_ANGLE_RAD: Final = 1.0e-3  # ... and of an angle
_NEST_MM: Final = 0.002  # of a certified nest
_COARSE: Final = ((1.0, 0.9), (3.0, 0.1))  # times these, and the share of arms: as made, as repaired
# What no model contains, of the tool at a stop and of each nest for good, and the share of arms: as good as
# their repeatability, everyday ones, worn ones.
_UNMODELLED: Final = ((0.0, 0.0, 0.4), (0.05, 0.02, 0.4), (0.15, 0.04, 0.2))
_TOOL_POINTS: Final = (1, 2, 3)
_HOLDING_NEST: Final = 0  # the setting ball sits in tool nest 1


class SessionForecast:
    """The lengths of one plan on the nominal arm of its cell, and what is unknown of them.

    Unknown are, in this order: the parameters of the arm (in the widths of their priors), the coordinates of
    the tool nests in the flange frame [mm], those of all cups in the world [mm].

    Parameters
    ----------
    cell : BallbarCell
    plan : BallbarPlan
        With a set-up for each cup.
    kit : BallbarKit
        How exact a clamped cup and a length are.
    """

    def __init__(self, cell: BallbarCell, plan: BallbarPlan, kit: BallbarKit) -> None:
        self._model = arm_model(cell)
        self._cell = cell
        self._kit = kit
        setups = [(placement.number, setup) for placement in plan.placements for setup in placement.setups]
        self._cups = [(number, setup.base_point) for number, setup in setups]
        self._held = np.array([setup.joints_rad for _, setup in setups], dtype=np.float64)
        self._cups_mm, self._cup_slope = self._nest_places(self._held)
        self._cups_mm = self._cups_mm[:, _HOLDING_NEST]
        self._cup_slope = self._cup_slope[:, _HOLDING_NEST]

    @property
    def unknowns(self) -> int:
        """Number of what is unknown."""
        return self._arm + 3 * len(self._cups)

    @property
    def fitted(self) -> int:
        """Number of what a fit to lengths would find: arm and cups."""
        return self._model.parameters + 3 * len(self._cups)

    @property
    def _arm(self) -> int:
        return self._model.parameters + 9

    def kinds(self) -> tuple[ArmKind, ...]:
        """Return the kinds of arms that it may be, the likeliest first.

        Returns
        -------
        tuple of ArmKind
            Six, of shares that make 1.
        """
        return tuple(
            self._kind(coarse, *unmodelled, share=share * of_these)
            for (coarse, share), (*unmodelled, of_these) in product(_COARSE, _UNMODELLED)
        )

    def poses(self, placement: int, joints_rad: FloatArray) -> tuple[StopLengths, ...]:
        """Return the lengths of every pair of a cup of a placement and a nest.

        Parameters
        ----------
        placement : int
            From 1.
        joints_rad : ndarray, shape (n, J)

        Returns
        -------
        tuple of StopLengths
            One a configuration.
        """
        points = [point for number, point in self._cups if number == placement]
        rows = [self._cups.index((placement, point)) for point in points]
        pairs: tuple[Leg, ...] = tuple(product(points, _TOOL_POINTS))
        nests, slopes = self._nest_places(joints_rad)
        return tuple(self._stop(pairs, rows, nests[stop], slopes[stop]) for stop in range(len(joints_rad)))

    def sides(self, placement: int) -> StopLengths:
        """Return the lengths between the cups of a placement, which no motion of the arm changes.

        Parameters
        ----------
        placement : int
            From 1.

        Returns
        -------
        StopLengths
        """
        points = [point for number, point in self._cups if number == placement]
        pairs: tuple[Leg, ...] = tuple(combinations(points, 2))
        first, second = ([self._cups.index((placement, pair[end])) for pair in pairs] for end in (0, 1))
        way, length = directions(self._cups_mm[second] - self._cups_mm[first])
        slope = np.zeros((len(pairs), self.unknowns))
        for row in range(len(pairs)):
            slope[row, self._of_cup(second[row])] = way[row]
            slope[row, self._of_cup(first[row])] = -way[row]
        return StopLengths(pairs, length, slope, np.zeros((len(pairs), 6)))

    def _stop(
        self, pairs: tuple[Leg, ...], rows: list[int], nests: FloatArray, slopes: FloatArray
    ) -> StopLengths:
        cup = np.repeat(rows, len(_TOOL_POINTS))
        nest = np.tile(np.arange(len(_TOOL_POINTS)), len(rows))
        way, length = directions(nests[nest] - self._cups_mm[cup])
        slope = np.zeros((len(pairs), self.unknowns))
        slope[:, : self._arm] = np.einsum("pi,pis->ps", way, slopes[nest])
        for row, number in enumerate(cup.tolist()):
            slope[row, self._of_cup(number)] = -way[row]
        turn = -np.einsum("pi,pij->pj", way, cross_matrix((nests - nests.mean(axis=0))[nest])) / _LEVER_MM
        return StopLengths(pairs, length, slope, np.concatenate([way, turn], axis=1))

    def _nest_places(self, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nests (n, 3, 3) and their motion per unknown of arm and tool, (n, 3, 3, P + 9)."""
        nests, motion = self._model.nests(joints_rad)
        turned = chain_of(self._cell, joints_rad).end_rotation
        own = np.zeros((*nests.shape, 9))
        for nest in range(len(_TOOL_POINTS)):
            own[:, nest, :, 3 * nest : 3 * nest + 3] = turned
        return nests, np.concatenate([motion, own], axis=3)

    def _of_cup(self, number: int) -> slice:
        return slice(self._arm + 3 * number, self._arm + 3 * number + 3)

    def _kind(self, coarse: float, tool_mm: float, nest_mm: float, *, share: float) -> ArmKind:
        """Return one kind of arm: mean and covariance of what is unknown, and the tool's motion at stops.

        `coarse` is how many times as large errors of links are, `tool_mm` and `nest_mm` are what no model
        contains.
        """
        structure, scatter = self._model.structure, self._cell.robot.repeatability_mm
        own = [{"mm": _LINK_MM, "rad": _ANGLE_RAD}.get(spec.unit) for spec in structure.specs]
        width = [
            # What is neither a length nor an angle, as a compliance, keeps the width of its
            # prior.
            1.0 if mine is None else coarse * mine / spec.prior_width
            for mine, spec in zip(own, structure.specs, strict=True)
        ]
        of_nests = [float(np.hypot(_NEST_MM, nest_mm))] * 9
        arm = np.square([*width, *of_nests])
        held = self._cup_slope.reshape(-1, self._arm)
        # What moves the tool from stop to stop moved it where the cup was clamped, too.
        clamped = self._kit.setup_u_mm**2 + scatter**2 + tool_mm**2
        covariance = np.zeros((self.unknowns, self.unknowns))
        covariance[: self._arm, : self._arm] = np.diag(arm)
        covariance[self._arm :, : self._arm] = held * arm
        covariance[: self._arm, self._arm :] = (held * arm).T
        covariance[self._arm :, self._arm :] = (held * arm) @ held.T + clamped * np.eye(len(held))
        mean = np.zeros(self.unknowns)
        mean[: self._model.parameters] = structure.prior_means / structure.prior_widths
        # Cups go where the arm took them, its expected errors included.
        mean[self._arm :] = held @ mean[: self._arm]
        return ArmKind(share, mean, covariance, float(np.hypot(scatter, tool_mm)))


def forecast_lengths(cell: Cell, plan: BallbarPlan, kit: BallbarKit) -> SessionForecast | None:
    """Return what is known of the lengths of a plan.

    A plan whose legs the nominal arm does not bring into the ballbar's range was made for another one: it
    says nothing of the lengths to come.

    Parameters
    ----------
    cell : Cell
    plan : BallbarPlan
    kit : BallbarKit

    Returns
    -------
    SessionForecast or None
        None where too little is known of robot, tool or cups.
    """
    if not plan.placements or any(len(place.setups) != len(place.cups_mm) for place in plan.placements):
        return None
    try:
        known = SessionForecast(ballbar_cell(cell), plan, kit)
    except (ConfigurationError, WorkSpaceError):
        return None
    return known if _is_of_this_arm(known, plan, kit) else None


def _is_of_this_arm(known: SessionForecast, plan: BallbarPlan, kit: BallbarKit) -> bool:
    for placement in plan.placements:
        joints = np.array([pose.joints_rad for pose in placement.poses])
        if not len(joints):
            continue
        for pose, stop in zip(placement.poses, known.poses(placement.number, joints), strict=True):
            if not set(pose.legs) <= set(stop.pairs):
                return False
            rows = [stop.pairs.index(leg) for leg in pose.legs]
            if np.abs(stop.nominal_mm[rows] - kit.base_bars.nominal_mm).max() > kit.range_mm:
                return False
    return True


_MOSTLY: Final = 0.5  # share of exchanges that must show in a pose that is not named


def unseen_swaps(beforehand: SessionForecast, plan: BallbarPlan, kit: BallbarKit) -> tuple[int, ...]:
    """Return the poses before the pre-calibration in which most exchanges do not show at once.

    Parameters
    ----------
    beforehand : SessionForecast
    plan : BallbarPlan
    kit : BallbarKit

    Returns
    -------
    tuple of int
        Their configurations, in the order of their visits.
    """
    kinds = beforehand.kinds()
    seen = sum(kind.share * _shares_seen(beforehand, plan, kit, kind) for kind in kinds)
    poses = _before_precalibration(plan)
    return tuple(
        pose.config for pose, share in zip(poses, np.atleast_1d(seen), strict=True) if share < _MOSTLY
    )


def _before_precalibration(plan: BallbarPlan) -> list[PlannedPose]:
    poses = [pose for placement in plan.placements for pose in placement.poses]
    return poses[: plan.precalibrate_after]


def _shares_seen(
    beforehand: SessionForecast, plan: BallbarPlan, kit: BallbarKit, kind: ArmKind
) -> FloatArray:
    """Return the share of exchanges that show, of each pose in order."""
    noise = kit.reading_u_mm**2 + kit.zero_u_mm**2
    known, found = kind.covariance, []
    placement = 0
    for pose in _before_precalibration(plan):
        if pose.placement != placement:
            placement = pose.placement
            sides = beforehand.sides(placement)
            # Cups are read against each other before any pose: that is known of them then.
            known = _after(known, sides.slope, noise * np.eye(len(sides.pairs)))
        stop = beforehand.poses(placement, np.array([pose.joints_rad]))[0]
        rows = [stop.pairs.index(leg) for leg in pose.legs]
        slope, scatter = stop.slope[rows], _scatter(stop, rows, kind, noise)
        found.append(_share_seen(slope @ known @ slope.T + scatter, slope @ kind.covariance @ slope.T))
        known = _after(known, slope, scatter)
    return np.array(found)


def _scatter(stop: StopLengths, rows: list[int], kind: ArmKind, noise_mm2: float) -> FloatArray:
    motion = stop.motion[rows]
    return np.asarray(kind.motion_mm**2 * motion @ motion.T + noise_mm2 * np.eye(len(rows)))


def _share_seen(foreseen: FloatArray, spread: FloatArray) -> float:
    """Return how often two lengths differ by enough, from how sure they are and how far they spread.

    The mean over all pairs of erfc(t u / (d sqrt 2)), the chance that a normal difference of deviation d
    exceeds t u.
    """
    shares = []
    for a, b in combinations(range(len(foreseen)), 2):
        # Of lengths that move alike rounding may leave less than nothing.
        unsure, differ = (sqrt(max(c[a, a] + c[b, b] - 2.0 * c[a, b], 0.0)) for c in (foreseen, spread))
        shares.append(erfc(TOLD_APART * unsure / differ / sqrt(2.0)) if differ > 0.0 else 0.0)
    return float(np.mean(shares)) if shares else 1.0


def _after(known: FloatArray, slope: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the covariance of what is unknown after readings.

    V - V A' (A V A' + N)^-1 A V (Kalman's update).
    """
    shared = known @ slope.T
    return np.asarray(known - shared @ np.linalg.solve(slope @ shared + noise, shared.T))
