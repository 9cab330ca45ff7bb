r"""The pose that fits any number of legs best, with its covariance and a test of the fit.

Cups and nests are known with uncertainty only. They are not fitted: their errors are part of the error of
the legs, whose covariance is V = S + C S_c C' + N S_n N' (`leg_lengths`). To first order, minimising
r' V^-1 r gives the same pose, covariance and chi-squared as fitting them with their priors, with six unknowns
instead of twenty-one.

The starts are all exact solutions of the smallest sets of legs that can be solved, so no guess is needed.

References
----------
JCGM 102:2011 (GUM supplement 2), section 6.2: propagation for several output quantities.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import Leg
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.kinematics.frames import rotation_from_vector
from truepose.kinematics.pose_device.cascade import outward
from truepose.kinematics.pose_device.leg_lengths import Fixtures, linear_legs
from truepose.kinematics.pose_device.starts import starting_poses
from truepose.kinematics.poses import Pose, points_gradient

# Per coordinate of a nest. The nominal robot of the thesis is off by 1.7 mm in space (rms, chapter 4), 1 mm
# per coordinate; twice that, so that its worst 5.2 mm still counts as the robot's own error.
_ARM_U_MM = 2.0
# Both limits are used on squared distances over arm_u^2, which are chi-squared where the arm's errors are as
# supposed: a pose beyond the first stands for none, and the likelihoods of two differ by exp of half of them.
_FAR = 33.7  # 99.99 % quantile of chi-squared with 9 degrees of freedom, one for each nest coordinate
_LOG_ODDS = float(np.log(1000.0))  # by which the nearest must be more likely than the next


@dataclass(frozen=True, slots=True)
class RecognisedAssembly:
    """The assembly mode in which the legs were measured.

    Attributes
    ----------
    index : int
        In the sequence of poses that were compared.
    distance_mm : float
        Of its nests from the commanded ones, rms.
    margin_mm : float
        By which the next pose is farther; infinite where there is no other.
    """

    index: int  # in the sequence of poses that were compared
    distance_mm: float  # of its nests from the commanded ones, rms
    margin_mm: float  # by which the next pose is farther; infinite where there is no other


def recognise_assembly(
    commanded: Pose, candidates: Sequence[Pose], nests_mm: FloatArray, *, arm_u_mm: float = _ARM_U_MM
) -> RecognisedAssembly | None:
    """Return the pose that the commanded one stands for; None where none is near, or two are.

    Parameters
    ----------
    commanded : Pose
        By the nominal model, in the frame of the cups.
    candidates : sequence of Pose
        E.g. the four solutions of a design, in any order; those that are not finite are never chosen.
    nests_mm : ndarray, shape (3, 3)
        In the flange frame.
    arm_u_mm : float
        Standard uncertainty of the commanded place of a nest, per coordinate.

    Returns
    -------
    RecognisedAssembly or None
        The one that is a thousand times likelier than the next, and no farther than 9,999 of 10,000 such arms
        would be from theirs.
    """
    square = np.array([square_mm2(commanded, one, nests_mm) for one in candidates])
    order = np.argsort(np.where(np.isnan(square), np.inf, square), kind="stable")
    if not order.size or not square[order[0]] <= _FAR * arm_u_mm**2:
        return None
    nearest = float(square[order[0]])
    following = float(square[order[1]]) if order.size > 1 else np.nan
    # A solution that does not exist cannot be taken for this one.
    following = np.inf if np.isnan(following) else following
    if following - nearest < 2.0 * _LOG_ODDS * arm_u_mm**2:
        return None
    distance, beyond = np.sqrt(nearest / 3.0), np.sqrt(following / 3.0)
    return RecognisedAssembly(int(order[0]), float(distance), float(beyond - distance))


def is_clearly_nearer(
    nearest: Pose, following: Pose, commanded: Pose, nests_mm: FloatArray, *, arm_u_mm: float = _ARM_U_MM
) -> bool:
    """Say whether the first pose is a thousand times likelier than the second to be the commanded one.

    Parameters
    ----------
    nearest, following, commanded : Pose
    nests_mm : ndarray, shape (3, 3)
        In the flange frame.
    arm_u_mm : float
        Standard uncertainty of the commanded place of a nest, per coordinate; errors of coordinates are taken
        for independent and normal.
    """
    gained = square_mm2(following, commanded, nests_mm) - square_mm2(nearest, commanded, nests_mm)
    return gained >= 2.0 * _LOG_ODDS * arm_u_mm**2


def square_mm2(first: Pose, second: Pose, nests_mm: FloatArray) -> float:
    """Return the sum of the squared distances of the three nests between two poses.

    Parameters
    ----------
    first, second : Pose
    nests_mm : ndarray, shape (3, 3)
        In the flange frame.

    Returns
    -------
    float
        [mm2]; NaN where a pose is not finite.
    """
    return float(((first.points(nests_mm) - second.points(nests_mm)) ** 2).sum())


_ROUNDS = 50
_STILL_MM = 1e-9  # last step: a thousandth of what the ballbar resolves, a hundred times rounding at 1 m
_SAME_MM = 1e-5  # two starts that ended closer than this found one and the same pose
_LOST_MM = 1e4  # a step of ten metres: the start led nowhere
_AS_TRAVEL_MM = np.array([1.0, 1.0, 1.0, 100.0, 100.0, 100.0])  # turns as travel at the end of 100 mm
_CLEAR = 20.0  # difference of chi-squared that decides between two poses: odds of 1 to 22,000
_FREE = (
    "The leg lengths do not fully constrain the tool at this pose, so its position cannot be computed. "
    "Measure another leg, or skip the pose."
)


@dataclass(frozen=True, slots=True, eq=False)  # arrays: equal means the same object
class PoseEstimate:
    """A pose with what it rests on.

    Attributes
    ----------
    pose : Pose
    covariance : ndarray, shape (6, 6)
        Shift [mm], then turn [rad], about the axes of the cups' frame.
    residual_mm : ndarray, shape (n,)
        Observed minus predicted.
    chi2 : float
        Of these under the covariance of legs and fixtures [1].
    degrees_of_freedom : int
        n - 6
    """

    pose: Pose
    covariance: FloatArray  # (6, 6) shift [mm], then turn [rad], about the axes of the cups' frame
    residual_mm: FloatArray  # (n,) observed minus predicted
    chi2: float
    degrees_of_freedom: int  # n - 6


def least_squares_pose(
    fixtures: Fixtures,
    legs: Sequence[Leg],
    length_mm: FloatArray,
    covariance_mm2: FloatArray,
    *,
    commanded: Pose | None = None,
) -> PoseEstimate:
    """Return the pose that fits the legs best.

    Parameters
    ----------
    fixtures : Fixtures
    legs : sequence of (cup, nest), n >= 6
        A leg may stand there more than once.
    length_mm : ndarray, shape (n,)
    covariance_mm2 : ndarray, shape (n, n)
        Of the lengths alone.
    commanded : Pose, optional
        By the nominal model. Decides where several poses fit equally well, as six legs always do. Without it
        the poses below the cups are left out, and one of the others must be clearly the best.

    Raises
    ------
    ConfigurationError
        Arguments do not go together, no pose has these lengths, or several have and nothing decides.
    UnderdeterminedError
        There are fewer than six different legs, or the legs leave the tool free to move.
    """
    found = fitting_poses(fixtures, legs, length_mm, covariance_mm2)
    if commanded is not None:
        return _nearest(found, commanded, fixtures, legs, covariance_mm2)
    above = [one for one in found if _is_above(one.pose, fixtures, legs)]
    if not above:
        raise ConfigurationError(
            "The only poses with these lengths are below the cups. Check the labels of cups and nests."
        )
    if len(above) > 1 and above[1].chi2 - above[0].chi2 < _CLEAR:
        raise ConfigurationError(
            f"These {len(legs)} leg lengths are consistent with {len(above)} poses. Give the commanded pose."
        )
    return above[0]


def _nearest(
    found: Sequence[PoseEstimate],
    commanded: Pose,
    fixtures: Fixtures,
    legs: Sequence[Leg],
    covariance: FloatArray,
) -> PoseEstimate:
    """Return the pose next to the commanded one among those that fit about equally well."""
    there = linear_legs(fixtures, legs, commanded)
    total = covariance + there.fixtures_covariance_mm2
    normal = there.gradient.T @ cho_solve(_factor(total), there.gradient)
    if not _holds(normal, commanded, fixtures.nests_mm, there.length_mm, total):
        raise UnderdeterminedError(_FREE)  # else a solution elsewhere would be taken for this one
    # What fits far worse is no alternative, however near the commanded pose it is: the legs of the pose at
    # which they were read fit within their uncertainty.
    rivals = sorted(
        (one for one in found if one.chi2 < found[0].chi2 + _CLEAR),
        key=lambda one: square_mm2(one.pose, commanded, fixtures.nests_mm),
    )
    nearest, *others = (one.pose for one in rivals)
    if others and not is_clearly_nearer(nearest, others[0], commanded, fixtures.nests_mm):
        raise ConfigurationError(
            "Two poses close to the commanded one have these lengths. Measure another leg, or skip the pose."
        )
    return rivals[0]


def fitting_poses(
    fixtures: Fixtures, legs: Sequence[Leg], length_mm: FloatArray, covariance_mm2: FloatArray
) -> tuple[PoseEstimate, ...]:
    """Return every pose at which the misfit is least around it, best first.

    Parameters and errors as of `least_squares_pose`, but for those that come of choosing one.

    Returns
    -------
    tuple of PoseEstimate
        One or more, by chi-squared.
    """
    _check(fixtures, legs, length_mm, covariance_mm2)
    starts = starting_poses(fixtures.cups_mm, fixtures.nests_mm, legs, length_mm)
    if not starts:
        raise ConfigurationError(
            "No pose is consistent with these lengths, or only a pose with all legs in a plane. "
            "Measure the lengths again."
        )
    # All starts, and not only the best one: of six legs all solutions fit exactly, and which start leads to
    # the wanted one is known only behind the fit.
    settled = [_settled(fixtures, legs, length_mm, covariance_mm2, start) for start in starts]
    found: list[PoseEstimate] = []
    for one in sorted((one for one in settled if one is not None), key=lambda one: one.chi2):
        if all(square_mm2(one.pose, other.pose, fixtures.nests_mm) > _SAME_MM**2 for other in found):
            found.append(one)
    if not found:
        raise UnderdeterminedError(_FREE)
    return tuple(found)


def _check(fixtures: Fixtures, legs: Sequence[Leg], length_mm: FloatArray, covariance: FloatArray) -> None:
    cups = len(fixtures.cups_mm)
    if cups < 3 or fixtures.cups_mm.shape != (cups, 3) or fixtures.nests_mm.shape != (3, 3):
        raise ConfigurationError(
            "At least three cups and exactly three nests are needed, each as x, y, z in mm."
        )
    for cup, nest in legs:
        if not (1 <= cup <= cups and 1 <= nest <= 3):
            raise ConfigurationError(f"Leg B{cup} T{nest} connects points that the fixtures do not have.")
    if len(set(legs)) < 6:
        raise UnderdeterminedError(f"{len(set(legs))} different legs were given; a pose needs at least six.")
    # Told before anything is solved: such legs have solutions, but a whole row of them.
    if any(_swings(Counter(points)) for points in zip(*set(legs), strict=True)):
        raise UnderdeterminedError(_FREE)
    if length_mm.shape != (len(legs),) or covariance.shape != (len(legs), len(legs)):
        raise ConfigurationError(
            f"{len(legs)} legs need the same number of lengths and a covariance of that size."
        )
    if not (np.isfinite(length_mm).all() and (length_mm > 0.0).all() and np.isfinite(covariance).all()):
        raise ConfigurationError("Every leg needs a finite length greater than 0 mm and a finite covariance.")


def _swings(legs_at: Counter[int]) -> bool:
    """Say whether legs leave a body free whatever its pose: three hold a point, two points leave a hinge."""
    return len(legs_at) < 3 or sum(min(legs, 3) for legs in legs_at.values()) < 6


def _settled(
    fixtures: Fixtures, legs: Sequence[Leg], length_mm: FloatArray, covariance: FloatArray, pose: Pose
) -> PoseEstimate | None:
    """Return the minimum next to a start; None where there is none, or the legs leave the tool free.

    Gauss-Newton with the normal equations (G^T V^-1 G) s = G^T V^-1 r, V anew at each pose; turns are applied
    from the left, about the axes of the cups' frame.
    """
    for _ in range(_ROUNDS):
        # V follows the pose, since the same error of a cup is another error of a leg from elsewhere.
        here = linear_legs(fixtures, legs, pose)
        residual, total = length_mm - here.length_mm, covariance + here.fixtures_covariance_mm2
        weighing = _factor(total)
        normal = here.gradient.T @ cho_solve(weighing, here.gradient)
        try:
            step = np.linalg.solve(normal, here.gradient.T @ cho_solve(weighing, residual))
        except np.linalg.LinAlgError:
            return None
        if not np.abs(step).max() < _LOST_MM:
            return None
        if np.abs(step * _AS_TRAVEL_MM).max() < _STILL_MM:
            break
        pose = Pose(
            rotation_from_vector(np.asarray(step[3:], dtype=float)) @ pose.rotation, pose.origin_mm + step[:3]
        )
    else:
        return None
    if not _holds(normal, pose, fixtures.nests_mm, length_mm, total):
        return None
    chi2 = float(residual @ cho_solve(weighing, residual))
    return PoseEstimate(pose, np.asarray(np.linalg.inv(normal), dtype=float), residual, chi2, len(legs) - 6)


def _factor(covariance: FloatArray) -> tuple[FloatArray, bool]:
    """Return the Cholesky factor of the legs' covariance (n, n); raises ConfigurationError without one."""
    try:
        factor, lower = cho_factor(covariance)
    except np.linalg.LinAlgError as error:
        raise ConfigurationError(
            "The covariance of the lengths is not positive definite. Give each length an uncertainty greater "
            "than 0 mm."
        ) from error
    return np.asarray(factor, dtype=float), bool(lower)


def _holds(
    normal: FloatArray, pose: Pose, nests_mm: FloatArray, length_mm: FloatArray, total: FloatArray
) -> bool:
    """Say whether the legs hold the tool so well that straight lines replace the curves of the lengths.

    A nest that is off by d changes a leg of length l by up to d^2 / 2 l beyond the straight line. Where d is
    the standard uncertainty of the nest and this is more than the leg's own, the linear pose is uncertain by
    more than the range in which it is linear: neither it nor its covariance means anything.
    """
    values, vectors = np.linalg.eigh(normal * np.outer(1.0 / _AS_TRAVEL_MM, 1.0 / _AS_TRAVEL_MM))
    if values[0] <= values[-1] * 1e-13:  # singular as far as doubles can tell
        return False
    freest = vectors[:, 0] / _AS_TRAVEL_MM / np.sqrt(values[0])
    travel = np.linalg.norm(points_gradient(pose, nests_mm) @ freest, axis=1).max()
    return bool(travel**2 < 2.0 * length_mm.min() * np.sqrt(np.diagonal(total).max()))


def _is_above(pose: Pose, fixtures: Fixtures, legs: Sequence[Leg]) -> bool:
    """Say whether the tool is on the outer side of the cups in use; true where four are in use.

    With three cups their plane mirrors every solution; four that are not in a plane leave none below.
    """
    used = sorted({cup for cup, _ in legs})
    if len(used) > 3:
        return True
    height = pose.points(fixtures.nests_mm).mean(axis=0) - fixtures.cups_mm[used[0] - 1]
    return bool(height @ outward(fixtures.cups_mm, used) > 0.0)
