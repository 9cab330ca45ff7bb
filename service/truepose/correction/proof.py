"""Proof moves: pairs of configurations, without correction and with it, and what their readings say.

A pair shall bring a tool nest to one place, without correction and with it. The first configuration is one
that the controller itself would answer with: the target is where the nominal robot would then have the nest,
and how it would hold the tool. The second is the corrected one. With e_k, e'_k the errors read at the n
targets without and with correction, and f_k those that the model foretells without,

    gain = mean |e| / mean |e'|          share = sum f.e / sum f.f

the interval of the gain are percentiles of resampled pairs (B. Efron, R. J. Tibshirani, An Introduction to
the Bootstrap, 1993, chapter 13).
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.correction.joint_targets import correct
from truepose.correction.target_poses import Goals
from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model, Statistics
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.identification.model.estimates import identified_estimate, nominal_estimate, structure_of
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.identification.model.prediction import placed_variance
from truepose.identification.model.validity import require_same_robot
from truepose.identification.verdict.judge import expected_noise_mm, mean_norm, observation_block, statistics
from truepose.identification.verdict.relative_accuracy import relative_statistics
from truepose.messages.message import Message, message
from truepose.planning.tracker.plans import plan_validation
from truepose.planning.workspace.candidates import have_room_to_approach
from truepose.planning.workspace.space import WorkSpace


@dataclass(frozen=True, slots=True)
class Pairs(Table):
    """n targets, and how to reach them.

    Attributes
    ----------
    nest : ndarray of int, shape (n,)
    target_mm : ndarray, shape (n, 3)
        World.
    uncorrected_rad, corrected_rad : ndarray, shape (n, J)
    solved : ndarray of bool, shape (n,)
        Others have no correction.
    """

    nest: IntArray  # (n,)
    target_mm: FloatArray  # (n, 3) world
    uncorrected_rad: FloatArray  # (n, J)
    corrected_rad: FloatArray  # (n, J)
    solved: BoolArray  # (n,) others have no correction

    def __len__(self) -> int:
        return len(self.nest)


def pairs_of(model: Model, stops: Stops, nest: IntArray) -> Pairs:
    """Return the pair that begins with each of n stops of the controller's own.

    Parameters
    ----------
    model : Model
    stops : Stops
        n rows; direction, time and temperature count for both configurations.
    nest : ndarray of int, shape (n,)
        1-based.

    Raises
    ------
    ConfigurationError
        As of `correct`.
    """
    nominal = nominal_estimate(model)
    wanted = evaluate(nominal.structure, nominal.values, Targets(stops, nest))
    goals = Goals(stops, nest, wanted.unscaled_mm, wanted.chain.end_rotation)
    found = correct(model, goals)
    return Pairs(nest, wanted.unscaled_mm, stops.joints_rad, found.joints_rad, found.solved)


def plan_proof(space: WorkSpace, template: SessionPlan, model: Model, n: int, seed: int) -> SessionPlan:
    """Fill the stops of a template with pairs at random targets, corrected right after uncorrected.

    Parameters
    ----------
    space : WorkSpace
    template : SessionPlan
        Role, approach and all else.
    model : Model
        That is to be proved.
    n : int
        Number of targets; each is visited twice. Targets that the model cannot correct within the limits,
        or whose correction leaves no room to approach it, are left out.
    seed : int

    Raises
    ------
    ConfigurationError
        The model is of another robot, or not one of the targets can be corrected.
    WorkSpaceError, TooFewCandidatesError, NoWayError
        As of a validation's plan.
    """
    require_same_robot(model, space.robot)
    approached = replace(space, approach_offset_rad=template.approach_offset_rad)
    # Targets are drawn as those of a validation: the whole work space, by the same rules of what the arm may
    # do.
    drawn = plan_validation(approached, n, seed).stops
    joints, nest = np.array([stop.joints_rad for stop in drawn]), np.array([stop.nest for stop in drawn])
    stops = Stops(np.arange(n), joints, direction=approach_directions(joints, template.approach_offset_rad))
    pairs = pairs_of(model, stops, nest)
    # A stop at the edge of its range may be corrected to where its approach begins beyond a limit.
    reached = pairs.solved.copy()
    reached[reached] = have_room_to_approach(approached, pairs.corrected_rad[reached])
    if not reached.any():
        raise ConfigurationError(
            "None of the targets can be corrected. Check that the model is of this robot."
        )
    return replace(template, stops=tuple(_visits(pairs.taken(np.flatnonzero(reached)))))


def approach_directions(joints_rad: FloatArray, offset_rad: float | None) -> IntArray | None:
    """Return from which side joints come to stops.

    Parameters
    ----------
    joints_rad : ndarray, shape (n, J)
    offset_rad : float or None
        On all joints: where the last motion begins, less the stop.

    Returns
    -------
    ndarray of int, shape (n, J), or None
        -1 after an approach from above, +1 from below; None where that differs by the stop.
    """
    if not offset_rad:
        return None
    return np.full(joints_rad.shape, -int(np.sign(offset_rad)))


def _visits(pairs: Pairs) -> list[PlannedStop]:
    found = []
    for k in range(len(pairs)):
        for twice, joints in enumerate((pairs.uncorrected_rad[k], pairs.corrected_rad[k])):
            # Corrected right after uncorrected, so that what drifts is the same in both; numbers say which is
            # which.
            found.append(PlannedStop(2 * k + 1 + twice, tuple(joints.tolist()), int(pairs.nest[k])))
    return found


_ROUNDING_MM: Final = 1e-9  # of places of metres: no error is known to be less
_SAME_RAD: Final = 1e-5  # commanded angles are compared, which plans keep with all digits
_RESAMPLED: Final = 2000
_CORRECTS_ITSELF: Final = 0.5  # share of the foretold errors below which something else makes up for them
# One draw of the parameters makes the mean error of a whole robot larger or smaller by about a quarter.
_WITHIN: Final = 1.5


@dataclass(frozen=True, slots=True)
class ProofErrors:
    """From each of n targets to where its nest was read, without and with correction.

    Attributes
    ----------
    config : ndarray of int, shape (n,)
        Of the uncorrected stop.
    nest : ndarray of int, shape (n,)
    target_mm : ndarray, shape (n, 3)
        Where the instrument sees the target.
    before_mm, after_mm : ndarray, shape (n, 3)
    """

    config: IntArray  # (n,) of the uncorrected stop
    nest: IntArray  # (n,)
    target_mm: FloatArray  # (n, 3) where the instrument sees the target
    before_mm: FloatArray  # (n, 3)
    after_mm: FloatArray  # (n, 3)


@dataclass(frozen=True, slots=True)
class Proof:
    """A correction proved, or not, on n targets of the robot itself; errors of measured tool nests [mm].

    Attributes
    ----------
    before, after : Statistics
        Without and with correction.
    gain : float
        Mean error without over mean error with correction [1].
    gain_interval_95 : tuple of float
    promised_mm : float
        Mean error that model, arm and readings let expect with correction.
    foretold_share : float
        Of the foretold errors, how much was there without correction [1]; 1 where all, NaN where none is
        foretold.
    cautions : tuple of Message
    before_relative, after_relative : Statistics or None
        After the best rigid alignment; None: too few targets.
    errors : ProofErrors
    """

    before: Statistics
    after: Statistics
    gain: float  # mean error without over mean error with correction
    gain_interval_95: tuple[float, float]
    promised_mm: float  # mean error that model, arm and readings let expect with correction
    foretold_share: float  # of the foretold errors, how much was there without correction; 1 where all
    cautions: tuple[Message, ...]
    before_relative: Statistics | None  # after the best rigid alignment; None: too few targets
    after_relative: Statistics | None
    errors: ProofErrors

    @property
    def keeps_promise(self) -> bool:
        """Whether what is left is what was promised."""
        return self.after.mean_mm <= _WITHIN * self.promised_mm

    @property
    def proved(self) -> bool:
        """Whether the correction helps beyond chance and keeps its promise."""
        return self.gain_interval_95[0] > 1.0 and self.keeps_promise


def proof_of(model: Model, readings: PointReadings, scatter_mm: float, seed: int = 0) -> Proof:
    """Judge a model by pairs of readings, at stops that `plan_proof` planned with it.

    Parameters
    ----------
    model : Model
    readings : PointReadings
        Of stops numbered as planned; a target of which one reading is missing is left out.
    scatter_mm : float
        Repeatability of the arm per axis beside the stated uncertainties.
    seed : int, optional
        Of the resampling that the interval comes from (percentiles of resampled pairs).

    Returns
    -------
    Proof

    Raises
    ------
    ConfigurationError
        There are fewer than two pairs, a stop was read more than once, or the stops were not planned with
        this model; else as of `correct`.
    """
    first, second = _paired(readings.stops.config)
    # Worked out anew and compared: a proof of one model by the stops of another would say nothing of either.
    pairs = pairs_of(model, readings.stops.taken(first), readings.nest[first])
    _require_planned(pairs.corrected_rad, readings.stops.joints_rad[second])
    uncorrected, corrected = readings.taken(first), readings.taken(second)
    at_first, at_second = _foretold(model, uncorrected), _foretold(model, corrected)
    errors = ProofErrors(
        config=uncorrected.stops.config,
        nest=uncorrected.nest,
        target_mm=_seen(at_first, pairs.target_mm),
        before_mm=uncorrected.position_mm - _seen(at_first, pairs.target_mm),
        after_mm=corrected.position_mm - _seen(at_second, pairs.target_mm),
    )
    noise, promised = _expected(model, at_second, corrected, scatter_mm)
    share = _share(at_first.unscaled_mm - pairs.target_mm, errors.before_mm)
    gain, interval = _gain(errors.before_mm, errors.after_mm, seed)
    return Proof(
        before=statistics(errors.before_mm, noise),
        after=statistics(errors.after_mm, noise),
        gain=gain,
        gain_interval_95=interval,
        promised_mm=promised,
        foretold_share=share,
        cautions=tuple(_cautions(share, gain)),
        before_relative=relative_statistics(_seen(at_first, pairs.target_mm), uncorrected.position_mm, noise),
        after_relative=relative_statistics(_seen(at_second, pairs.target_mm), corrected.position_mm, noise),
        errors=errors,
    )


def _paired(config: IntArray) -> tuple[IntArray, IntArray]:
    """Return the rows of uncorrected and of corrected stops, of targets that have both."""
    numbers, times = np.unique(config, return_counts=True)
    if (times > 1).any():
        raise ConfigurationError(
            f"Configuration {int(numbers[np.argmax(times)])} was read {int(times.max())} times. A proof "
            "compares one reading without correction with one reading with correction; leave out the others."
        )
    row_of = {number: row for row, number in enumerate(config.tolist())}
    # Odd numbers are uncorrected stops, and the even one behind each is its correction.
    both = [number for number in sorted(row_of) if number % 2 == 1 and number + 1 in row_of]
    if len(both) < 2:
        raise ConfigurationError(
            "A proof needs at least two targets measured both without and with correction; these readings "
            f"have {len(both)}."
        )
    return np.array([row_of[n] for n in both]), np.array([row_of[n + 1] for n in both])


def _require_planned(corrected_rad: FloatArray, visited_rad: FloatArray) -> None:
    """Refuse readings at other joints (n, J) [rad] than this model corrects its targets to."""
    away = np.abs(corrected_rad - visited_rad).max(axis=1)
    if not (away < _SAME_RAD).all():
        raise ConfigurationError(
            f"These readings cannot prove this model: target {int(np.argmax(away)) + 1} was measured at "
            "joint angles other than those this model corrects it to. Plan the proof with the model to be "
            "proved."
        )


def _foretold(model: Model, readings: PointReadings) -> State:
    estimate = identified_estimate(model)
    return evaluate(estimate.structure, estimate.values, Targets(readings.stops, readings.nest))


def _seen(foretold: State, target_mm: FloatArray) -> FloatArray:
    """Return where the instrument sees targets, shape (n, 3).

    A target is moved as the instrument's scale and drift move the nest that is read beside it: the tool shall
    be there, and not be seen there.
    """
    return target_mm + foretold.position_mm - foretold.unscaled_mm


def _share(foretold_mm: FloatArray, before_mm: FloatArray) -> float:
    """Return how much of the foretold errors was read; NaN where the model foretells none.

    sum f.e / sum f.f over all targets, the slope of a line through the origin: (n, 3) and (n, 3) [mm].
    """
    square = float((foretold_mm**2).sum())
    return float((foretold_mm * before_mm).sum()) / square if square else math.nan


def _expected(model: Model, state: State, readings: PointReadings, scatter_mm: float) -> tuple[float, float]:
    """Return the mean norm of what readings and scatter alone give, and with what the model leaves [mm].

    The model's variance contains its own robot's repeatability, in whose place comes that of this cell's arm.
    """
    block = observation_block(readings, scatter_mm, structure_of(model))
    own = placed_variance(model, state) - model.repeatability_mm**2 + scatter_mm**2
    promised = mean_norm(block.covariance() + own[:, None, None] * np.eye(3))
    return expected_noise_mm(block), promised


def _gain(before: FloatArray, after: FloatArray, seed: int) -> tuple[float, tuple[float, float]]:
    # The errors of a simulated robot without noise are 0: the ratio is then a large number instead of none.
    """Return the gain of errors (n, 3) [mm] and its 95 % interval, 2,000 draws of n pairs with a seed."""
    norms = np.stack([np.linalg.norm(errors, axis=1) for errors in (before, after)]).clip(_ROUNDING_MM)
    # Pairs are drawn, not errors: a target that is far off is so in both of its readings.
    drawn = np.random.default_rng(seed).integers(0, norms.shape[1], (_RESAMPLED, norms.shape[1]))
    means = norms[:, drawn].mean(axis=2)
    low, high = np.percentile(means[0] / means[1], [2.5, 97.5])
    return float(norms[0].mean() / norms[1].mean()), (float(low), float(high))


def _cautions(share: float, gain: float) -> list[Message]:
    """Say what explains a correction that does not help."""
    if math.isnan(share) or share >= _CORRECTS_ITSELF:
        return []
    # Where nothing of the foretold was there and correction made it worse, the controller corrects already.
    if gain < 1.0:
        return [message("proof.corrects_itself", share=share)]
    return [message("proof.not_as_foretold", share=share)]
