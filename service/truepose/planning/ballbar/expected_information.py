r"""How well a ballbar session will know the arm: information of its readings, and error of what is predicted.

Unknown are the geometry and compliances of the arm and the places of the cups, and of certified nests what
their certificates allow; the base is held, as only places relative to the cups can be seen. Observed are

    legs      |nest_j(q) - cup_i|     scatter: the arm's, common to the legs of a stop, and the ballbar's own
    set-ups   cup_i - nest_1(q_i)     how well a cup sits where the ball was held
    sides     |cup_i - cup_k|         with the ballbar, those of the tool |nest_j - nest_k| as well

With w_ij the unit vector from cup to nest, J the motion of the nests per parameter and S the covariance of
the legs of a stop,

    d leg = w_ij . (J_j dp - dcup_i)        S = l^2 I + s^2 W W'        rows: S^-1/2 [W J, -W]

The figure is the root mean square error of nest positions over the work space, in the frame that the cups
define (the rigid motion that fits predicted to true cups best taken off): what a user of the model sees.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.ballbar import Leg
from truepose.kinematics.frames import cross_matrix
from truepose.planning.ballbar.arm_model import ArmModel, Scatter

SPACE_POINTS: Final = 200  # configurations over which errors are averaged
_CUP_WIDTH_MM: Final = 10.0  # nothing worth mentioning is known of a cup beforehand


@dataclass(frozen=True, slots=True)
class PoseRows:
    """Whitened derivatives of the legs of n configurations from one placement."""

    arm: FloatArray  # (n, L, P)
    cups: FloatArray  # (n, L, 3 K) per prior width of a cup's coordinate

    def __len__(self) -> int:
        return len(self.arm)

    def some(self, keep: IntArray) -> "PoseRows":
        """Return the rows of some configurations, indices `keep` (k,)."""
        return PoseRows(self.arm[keep], self.cups[keep])


def pose_rows(
    model: ArmModel, cups_mm: FloatArray, joints_rad: FloatArray, legs: Sequence[Sequence[Leg]]
) -> PoseRows:
    """Return the whitened derivatives of legs; a configuration with fewer legs than others has rows of zeros.

    Parameters
    ----------
    model : ArmModel
    cups_mm : ndarray, shape (K, 3)
        [mm, world].
    joints_rad : ndarray, shape (n, J)
    legs : n sequences of legs
        Cup and nest, 1-based, in the order of their readings.

    Returns
    -------
    PoseRows
        L is the largest number of legs.
    """
    nests, motion = model.nests(joints_rad)
    base, nest, there = _padded(legs)
    row = np.arange(len(legs))[:, None]
    way = nests[row, nest] - cups_mm[base]
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    # A leg that is not there is a length that nothing moves: it stays in the arrays and says nothing.
    way *= there[:, :, None]
    white = (_erring if model.erring else _whitener)(model.scatter, way)
    arm = white @ np.einsum("nli,nlip->nlp", way, motion[row, nest])
    ends = np.eye(len(cups_mm))[base]  # (n, L, K) the cup of each leg
    cups = -_CUP_WIDTH_MM * (ends[:, :, :, None] * way[:, :, None]).reshape(*base.shape, 3 * len(cups_mm))
    return PoseRows(arm, white @ cups)


def _padded(legs: Sequence[Sequence[Leg]]) -> tuple[IntArray, IntArray, BoolArray]:
    """Cup and nest (0-based) of every leg, and whether there is one, (n, L) each."""
    most = max((len(own) for own in legs), default=0)
    padded = [[*own, *[(0, 0)] * (most - len(own))] for own in legs]
    pairs = np.array(padded, dtype=np.int64).reshape(len(legs), most, 2)
    there: BoolArray = pairs[:, :, 0] > 0
    first = np.maximum(pairs - 1, 0)
    return first[:, :, 0], first[:, :, 1], there


def _whitener(scatter: Scatter, way: FloatArray) -> FloatArray:
    """Return S^-1/2 of lengths whose nests share one shift of the arm, shape (n, L, L).

    L^-1 of Cholesky's S = L L'.
    """
    return np.asarray(np.linalg.inv(np.linalg.cholesky(_stated_mm2(scatter, way))))


def _stated_mm2(scatter: Scatter, way: FloatArray) -> FloatArray:
    """Return S = l^2 I + s^2 W W' of lengths along `way` (n, L, 3), shape (n, L, L) [mm2]."""
    own = scatter.leg_mm**2 * np.eye(way.shape[1])
    return np.asarray(own + scatter.stop_mm**2 * way @ np.swapaxes(way, 1, 2))


def _erring(scatter: Scatter, way: FloatArray) -> FloatArray:
    """Return F, shape (n, L, L): F'F is the covariance of lengths between two of their stated inverses.

    F'F = S^-1 T S^-1 with S as stated and T as true, in which the zero of each reading is that of a walk.
    With derivatives A, A'F'F A is then the scatter of the sums A' S^-1 r that an identification forms,
    whatever r truly scatter by.
    """
    stated, lines = _stated_mm2(scatter, way), way.shape[1]
    true = stated + scatter.walked_mm2(lines) - scatter.zero_mm**2 * np.eye(lines)
    return np.asarray(np.swapaxes(np.linalg.cholesky(true), 1, 2) @ np.linalg.inv(stated))


def setting_information(model: ArmModel, cups_mm: FloatArray, setups_rad: FloatArray | None) -> FloatArray:
    """Return what priors, set-ups and sides say of arm and cups.

    Parameters
    ----------
    model : ArmModel
    cups_mm : ndarray, shape (K, 3)
    setups_rad : ndarray, shape (K, J), optional
        Where the arm held the ball at each cup; None: nobody knows.

    Returns
    -------
    ndarray, shape (P + 3 K, P + 3 K)
        Per prior width; I + rows' rows.
    """
    count, cups = model.parameters, len(cups_mm)
    sides = []
    for a, b in combinations(range(cups), 2):
        way = (cups_mm[b] - cups_mm[a]) / np.linalg.norm(cups_mm[b] - cups_mm[a])
        row = np.zeros(count + 3 * cups)
        row[count + 3 * a : count + 3 * a + 3] = -way * _CUP_WIDTH_MM
        row[count + 3 * b : count + 3 * b + 3] = way * _CUP_WIDTH_MM
        sides.append(row)
    rows = [_read_in_one_go(model, np.array(sides))]
    if setups_rad is not None:
        rows.append(_setup_rows(model, setups_rad))
    stacked = np.concatenate(rows)
    return np.asarray(np.eye(count + 3 * cups) + stacked.T @ stacked)


def _read_in_one_go(model: ArmModel, sides: FloatArray) -> FloatArray:
    """Return whitened derivatives of sides (k, columns) that are read after one initialisation.

    A / s as they are weighed; as they err, F with F'F = T / s^4 and T the covariance of a walking zero
    (`_erring`).
    """
    scatter, lines = model.scatter, len(sides)
    if not model.erring:
        return np.asarray(sides / scatter.side_mm)
    true = (scatter.side_mm**2 - scatter.zero_mm**2) * np.eye(lines) + scatter.walked_mm2(lines)
    return np.asarray(np.linalg.cholesky(true).T @ sides / scatter.side_mm**2)


def _setup_rows(model: ArmModel, setups_rad: FloatArray) -> FloatArray:
    """Return the whitened derivatives of cup_k - nest_1(q_k), shape (3 K, P + 3 K).

    A cup sits off the ball by `setup_mm`, and the ball off the model by `stop_mm`, both per axis.
    """
    cups, count = len(setups_rad), model.parameters
    _, motion = model.nests(setups_rad)
    size = float(np.hypot(model.scatter.setup_mm, model.scatter.stop_mm))
    rows = np.zeros((3 * cups, count + 3 * cups))
    rows[:, :count] = -motion[:, 0].reshape(3 * cups, count) / size
    rows[:, count:] = np.eye(3 * cups) * _CUP_WIDTH_MM / size
    return rows


@dataclass(frozen=True, slots=True)
class SessionInformation:
    """Information about arm and the cups of all placements so far, cups in the order of the placements."""

    matrix: FloatArray  # (P + 3 C, P + 3 C)
    cups_mm: FloatArray  # (C, 3)


def information_beforehand(model: ArmModel) -> SessionInformation:
    """Return what is known before any placement: priors, and the sides of an uncertain tool triangle.

    Parameters
    ----------
    model : ArmModel

    Returns
    -------
    SessionInformation
        Of the arm alone, without cups.
    """
    sides = _tool_side_rows(model)
    return SessionInformation(np.eye(model.parameters) + sides.T @ sides, np.zeros((0, 3)))


def _tool_side_rows(model: ArmModel) -> FloatArray:
    """Return the whitened derivatives of the sides between tool nests, shape (3, P), wherever the arm is.

    w . (J_b - J_a) with w along the side. None, shape (0, P), where the nests are taken for exact.
    """
    if model.own_parameters == model.parameters:
        return np.zeros((0, model.parameters))
    (nests,), (motion,) = model.nests(np.zeros((1, model.cell.robot.n_joints)))
    rows = []
    for a, b in combinations(range(len(nests)), 2):
        way = nests[b] - nests[a]
        rows.append(way @ (motion[b] - motion[a]) / np.linalg.norm(way))
    return _read_in_one_go(model, np.array(rows))


def with_placement(before: SessionInformation, own: FloatArray, cups_mm: FloatArray) -> SessionInformation:
    """Add a placement.

    Parameters
    ----------
    before : SessionInformation
        Of arm and C cups.
    own : ndarray, shape (P + 3 K, P + 3 K)
        Of the placement, with the priors of the arm in it.
    cups_mm : ndarray, shape (K, 3)

    Returns
    -------
    SessionInformation
        Of arm and C + K cups.
    """
    k, arm, c = 3 * len(cups_mm), len(own) - 3 * len(cups_mm), 3 * len(before.cups_mm)
    matrix = np.zeros((arm + c + k, arm + c + k))
    matrix[: arm + c, : arm + c] = before.matrix
    index = np.r_[0:arm, arm + c : arm + c + k]
    matrix[np.ix_(index, index)] += own
    matrix[:arm, :arm] -= np.eye(arm)  # priors count once
    return SessionInformation(matrix, np.concatenate([before.cups_mm, cups_mm]))


@dataclass(frozen=True, slots=True)
class WorkSpaceSample:
    """Nests at configurations all over the work space, with their motion per prior width of the arm."""

    position_mm: FloatArray  # (m, 3)
    motion: FloatArray  # (m, 3, P)


def work_space_sample(model: ArmModel, n: int, rng: np.random.Generator) -> WorkSpaceSample:
    """Draw n configurations uniformly in the ranges, whose nests are above the table.

    Parameters
    ----------
    model : ArmModel
    n : int
        Fewer where of 4 n draws not as many are above the table; none where that is out of reach.
    rng : numpy.random.Generator

    Returns
    -------
    WorkSpaceSample
        m = 3 n places.
    """
    cell = model.cell
    low = np.array([limit.lower_rad for limit in cell.ranges])
    high = np.array([limit.upper_rad for limit in cell.ranges])
    # Four times as many, as some have nests below the table.
    drawn = low + (high - low) * rng.random((4 * n, len(low)))
    position, motion = model.nests(drawn)
    above = np.flatnonzero((position[:, :, 2] > cell.table_z_mm).all(axis=1))[:n]
    return WorkSpaceSample(position[above].reshape(-1, 3), motion[above].reshape(-1, 3, model.parameters))


def predicted_error_mm(known: SessionInformation, sample: WorkSpaceSample) -> float:
    """Return the root mean square error (norm) of nest positions in the frame of the cups, sqrt(tr(W M^-1)).

    Parameters
    ----------
    known : SessionInformation
    sample : WorkSpaceSample
        One place at least.

    Returns
    -------
    float
        [mm].
    """
    weight = error_weight(known.cups_mm, sample)
    return float(np.sqrt(np.sum(weight * np.linalg.inv(known.matrix))))


def error_weight(cups_mm: FloatArray, sample: WorkSpaceSample) -> FloatArray:
    """Return W: the mean square error of nest positions is tr(W C), C the covariance of arm and cups.

    W is the mean of G' G over the places. Errors count in the frame of the cups, as in `error_gradient`.

    Parameters
    ----------
    cups_mm : ndarray, shape (C, 3)
    sample : WorkSpaceSample
        One place at least.

    Returns
    -------
    ndarray, shape (P + 3 C, P + 3 C)
        Per prior width [mm2].
    """
    gradient = error_gradient(cups_mm, sample)
    flat = gradient.reshape(-1, gradient.shape[2])
    return np.asarray(flat.T @ flat / len(gradient))


def error_gradient(cups_mm: FloatArray, sample: WorkSpaceSample) -> FloatArray:
    """Return how nests at m places move in the frame of C cups.

    With A_x = [I, -[x]x] how a point x moves with a small rigid motion, the motion that fits the cups' errors
    best is A_cups^+ dcups; G = [J, -A_x A_cups^+] takes it off.

    Parameters
    ----------
    cups_mm : ndarray, shape (C, 3)
        Three at least, not on a line.
    sample : WorkSpaceSample

    Returns
    -------
    ndarray, shape (m, 3, P + 3 C)
        Per prior width [mm].
    """
    turns = np.concatenate([np.tile(np.eye(3), (len(cups_mm), 1, 1)), -cross_matrix(cups_mm)], axis=2)
    fit = np.linalg.pinv(turns.reshape(-1, 6)) * _CUP_WIDTH_MM  # (6, 3 C)
    points = sample.position_mm
    carried = np.concatenate([np.tile(np.eye(3), (len(points), 1, 1)), -cross_matrix(points)], axis=2)
    return np.concatenate([sample.motion, -(carried @ fit)], axis=2)


def of_poses(rows: PoseRows, chosen: IntArray | None = None, weight: float = 1.0) -> FloatArray:
    """Return what configurations say of arm and cups, weight * rows' rows.

    Parameters
    ----------
    rows : PoseRows
    chosen : ndarray, optional
        Indices; by default all.
    weight : float
        Of each configuration.

    Returns
    -------
    ndarray, shape (P + 3 K, P + 3 K)
        Per prior width.
    """
    stacked = np.concatenate([rows.arm, rows.cups], axis=2)
    flat = (stacked if chosen is None else stacked[chosen]).reshape(-1, stacked.shape[2])
    return np.asarray(weight * flat.T @ flat)
