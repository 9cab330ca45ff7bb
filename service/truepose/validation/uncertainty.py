"""How well the figures of a validation are known, and what that consists of: GUM, to first order.

What is uncertain of an error is where the place was read, reading by reading, and where the model believes
the robot to stand, which is the same in all of them. With A the derivatives of a figure in the readings, S
the covariance of each reading, J the rigid motions of all places and C their covariance,

    u^2 = sum A_i^T S_i A_i + q^T C q,        q = sum J_i A_i.

Distances between all pairs are no independent figures: each reading has a part in n - 1 of them. Their
derivatives are summed reading by reading, over all others, or of many readings over some spread evenly among
them. Where errors are hardly larger than noise this is too cautious, by a fifth for means and up to twice for
the largest.

References
----------
JCGM 100:2008 (GUM), 5.2.2 (correlated input quantities).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.identification import Model, Statistics
from truepose.domain.validation import FigureUncertainty, UncertaintyPair, ValidationUncertainty
from truepose.identification.verdict.judge import Assessment
from truepose.identification.verdict.relative_accuracy import aligned_errors, rigid_motions
from truepose.validation.distance_errors import Distances

ROUNDING_MM: Final = 1e-6  # scatter of a reading whose file states none worth the name


@dataclass(frozen=True, slots=True)
class Figure:
    """A value with its standard uncertainty."""

    value: float
    standard_uncertainty: float

    @property
    def is_seen(self) -> bool:
        """Whether it is more than readings scatter by: 3 standard uncertainties."""
        return abs(self.value) > 3.0 * self.standard_uncertainty


_ALL_PAIRS: Final = 512  # readings, up to which every pair takes part
_PARTNERS: Final = 128  # of each reading, where there are more
_CHUNK: Final = 64  # readings at a time
PICOMETRES: Final = 9  # decimals of mm; a model that comes from its file differs in the last bits only
_TINY_MM: Final = 1e-12  # figures and lengths that are nothing have no direction


@dataclass(frozen=True, slots=True)
class Uncertainties:
    """How well n readings of d components, and the placement of the robot, are known.

    Attributes
    ----------
    covariance : ndarray, shape (n, d, d)
        Of each reading.
    motion : ndarray, shape (m, n, d)
        Of the places, m at most 6, orthonormal.
    placement : ndarray, shape (m, m)
        Covariance of these motions.
    """

    covariance: FloatArray
    motion: FloatArray
    placement: FloatArray

    def of(self, gradient: FloatArray) -> float:
        """Return the standard uncertainty of a figure.

        Parameters
        ----------
        gradient : ndarray, shape (n, d)
            Its derivatives in the readings.

        Returns
        -------
        float
            In the unit of the figure, to 1e-9.
        """
        own = np.einsum("ni,nij,nj->", gradient, self.covariance, gradient, optimize=True)
        shared = np.tensordot(self.motion, gradient, 2)
        return round(float(np.sqrt(max(own + shared @ self.placement @ shared, 0.0))), PICOMETRES)

    def of_single(self) -> FloatArray:
        """Return the covariance of each error.

        Returns
        -------
        ndarray, shape (n, d, d)
            [mm2].
        """
        shared = np.einsum("pni,pq,qnj->nij", self.motion, self.placement, self.motion, optimize=True)
        return np.asarray(self.covariance + shared)


def known(model: Model, judged: Assessment) -> Uncertainties:
    """Return what is uncertain of the errors of a model: its readings, and where it believes the robot to be.

    That is the rigid motion which all its parameters together are uncertain by: base, tool and geometry are
    often seen only together. With Q the orthonormal rigid motions and J the derivatives, C_m = Q' J' C J Q.

    Parameters
    ----------
    model : Model
    judged : Assessment
        The model against n >= 1 readings.

    Returns
    -------
    Uncertainties
        Lengths know no place of the robot: no motions.
    """
    if judged.block.place_mm is None:
        nothing = np.zeros((0, *judged.identified_mm.shape))
        return Uncertainties(judged.block.covariance(), nothing, np.zeros((0, 0)))
    # Orthonormal, so that shifts and turns, nearly equal motions of places far from the origin, count once.
    motions, _ = np.linalg.qr(rigid_motions(judged.places_mm))
    jacobian = judged.identified.jacobian
    moved = jacobian.reshape(len(jacobian), len(motions)) @ motions
    # A model whose file states no uncertainty has NaN there: nothing is counted, and nothing is claimed of
    # it.
    placement = moved.T @ np.nan_to_num(model.covariance) @ moved
    return Uncertainties(
        judged.block.covariance(), motions.T.reshape(-1, *judged.identified_mm.shape), placement
    )


def figure_uncertainty(
    model: Model, judged: Assessment, distances: Distances | None, *, aligned: bool
) -> ValidationUncertainty:
    """Return the standard uncertainty of every figure of a validation.

    Parameters
    ----------
    model : Model
    judged : Assessment
        The model against n >= 1 readings.
    distances : Distances or None
        Of all pairs, where there are pairs.
    aligned : bool
        Whether there are figures after an alignment.

    Returns
    -------
    ValidationUncertainty
    """
    inputs = known(model, judged)
    return ValidationUncertainty(
        position=UncertaintyPair(
            _of_sizes(judged.nominal_mm, inputs), _of_sizes(judged.identified_mm, inputs)
        ),
        relative=_of_relative(judged, inputs) if aligned else None,
        distance=None if distances is None else _of_distances(judged, distances, inputs),
    )


def _of_sizes(
    errors_mm: FloatArray, inputs: Uncertainties, taken: FloatArray | None = None
) -> FigureUncertainty:
    """Return the uncertainties of the norms of errors (n, d).

    Derivatives in an error e_i of norm n_i: of the mean e_i / (n n_i), of the RMS r e_i / (n r), of the
    standard deviation s (n_i - mean) e_i / ((n - 1) s n_i). `taken`, shape (n d, k), spans what an alignment
    takes.
    """

    def u(gradient: FloatArray) -> float:
        """Return the uncertainty of a figure, past what an alignment takes of its derivatives."""
        if taken is None:
            return inputs.of(gradient)
        flat = gradient.reshape(-1)
        return inputs.of((flat - taken @ (taken.T @ flat)).reshape(gradient.shape))

    norms = np.linalg.norm(errors_mm, axis=1)
    n, unit = len(norms), errors_mm / np.maximum(norms, _TINY_MM)[:, None]
    rms, sd = float(np.sqrt((norms**2).mean())), float(norms.std(ddof=1)) if n > 1 else 0.0
    largest = np.arange(n) == int(np.argmax(norms))
    away = (norms - norms.mean()) / (max(n - 1, 1) * max(sd, _TINY_MM))
    return FigureUncertainty(
        mean_mm=u(unit / n),
        rms_mm=u(errors_mm / (n * max(rms, _TINY_MM))),
        sd_mm=u(unit * away[:, None]),
        max_mm=u(unit * largest[:, None]),
    )


def _of_relative(judged: Assessment, inputs: Uncertainties) -> UncertaintyPair:
    """Return the uncertainties after the best rigid alignment, for both models."""
    places = judged.places_mm
    motions, _ = np.linalg.qr(rigid_motions(places))
    nominal, identified = (
        _of_sizes(aligned_errors(predicted, places), inputs, motions)
        for predicted in (judged.nominal.state.position_mm, judged.position_mm)
    )
    return UncertaintyPair(nominal, identified)


def _of_distances(judged: Assessment, distances: Distances, inputs: Uncertainties) -> UncertaintyPair:
    """Return the uncertainties of the distances between all pairs, for both models."""
    places = judged.places_mm
    nominal, identified = (
        _of_pairs(places, predicted, found, inputs)
        for predicted, found in (
            (judged.nominal.state.position_mm, distances.sizes.nominal),
            (judged.position_mm, distances.sizes.identified),
        )
    )
    return UncertaintyPair(nominal, identified)


def _of_pairs(
    seen_mm: FloatArray, predicted_mm: FloatArray, found: Statistics, inputs: Uncertainties
) -> FigureUncertainty:
    """Return the uncertainties of the errors of distances: each derivative summed reading by reading.

    d|s_i - s_j| / ds_i is the unit vector u_ij, so that a figure of derivative w_ij in each error has in
    reading i 2 / (n (n - 1)) sum_j w_ij u_ij for a mean over pairs.
    """
    gradients = np.zeros((4, *seen_mm.shape))
    worst, error_mm = np.zeros_like(seen_mm), -1.0
    for pairs in _pairs(seen_mm, predicted_mm):
        # Of many readings each has some partners only, which represent all others.
        share = 2.0 / (len(seen_mm) * np.maximum(pairs.counts.sum(axis=1), 1))
        for gradient, weight in zip(gradients, pairs.weights(found.mean_mm), strict=True):
            gradient[pairs.rows] = share[:, None] * np.einsum("ij,ijk->ik", weight, pairs.unit)
        at = np.unravel_index(np.argmax(pairs.size), pairs.size.shape)
        # Two readings alone decide the largest error; its derivative is that of their distance.
        if pairs.size[at] > error_mm:
            error_mm, worst = float(pairs.size[at]), np.zeros_like(seen_mm)
            worst[pairs.rows[at[0]]] += pairs.unit[at]
            worst[pairs.partners[at[1]]] -= pairs.unit[at]
    mean, square, spread, signed = map(inputs.of, gradients)
    return FigureUncertainty(
        mean_mm=mean,
        rms_mm=square / max(found.rms_mm, _TINY_MM),
        # Of one pair the deviation is 0 by definition.
        sd_mm=spread / max(found.sd_mm, _TINY_MM) if found.n > 1 else 0.0,
        max_mm=inputs.of(worst),
        signed_mean_mm=signed,
    )


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Some readings against their partners.

    Attributes
    ----------
    rows : ndarray of int, shape (a,)
    partners : ndarray of int, shape (b,)
    counts : ndarray of bool, shape (a, b)
        False of a reading with itself.
    unit : ndarray, shape (a, b, 3)
        Towards each row from its partner.
    error_mm : ndarray, shape (a, b)
        Of the distance.
    """

    rows: IntArray
    partners: IntArray
    counts: BoolArray
    unit: FloatArray
    error_mm: FloatArray

    @property
    def size(self) -> FloatArray:
        """Sizes of the errors, shape (a, b) [mm]."""
        return np.abs(self.error_mm)

    def weights(self, mean_mm: float) -> Iterator[FloatArray]:
        """Yield by what each error moves its mean size, square, spread of sizes and mean with sign.

        Parameters
        ----------
        mean_mm : float
            Mean size.

        Yields
        ------
        ndarray, shape (a, b)
        """
        sign = np.sign(self.error_mm)
        yield sign
        yield self.error_mm
        yield (self.size - mean_mm) * sign
        yield self.counts.astype(float)


def _pairs(seen_mm: FloatArray, predicted_mm: FloatArray) -> Iterator[_Pairs]:
    """Yield all readings, some at a time, against all others or against some spread evenly among them."""
    n = len(seen_mm)
    partners = np.arange(n) if n <= _ALL_PAIRS else np.linspace(0, n - 1, _PARTNERS).astype(np.int64)
    for first in range(0, n, _CHUNK):
        rows = np.arange(first, min(first + _CHUNK, n))
        apart = seen_mm[rows, None] - seen_mm[partners]
        length = np.linalg.norm(apart, axis=2)
        foreseen = np.linalg.norm(predicted_mm[rows, None] - predicted_mm[partners], axis=2)
        unit = apart / np.maximum(length, _TINY_MM)[:, :, None]
        yield _Pairs(rows, partners, rows[:, None] != partners, unit, length - foreseen)


@dataclass(frozen=True, slots=True)
class DecidingReading:
    """An error, and its standard uncertainties along it.

    Attributes
    ----------
    config : int
    error_mm : float
    reading_u_mm : float
        Of where the place was read.
    placement_u_mm : float
        Of where the model believes the robot to stand.
    """

    config: int
    error_mm: float
    reading_u_mm: float
    placement_u_mm: float

    @property
    def combined_u_mm(self) -> float:
        """Both together: what the guard band is a multiple of."""
        return float(np.hypot(self.reading_u_mm, self.placement_u_mm))


def deciding_reading(
    judged: Assessment, known: Uncertainties, error_mm: float | None = None
) -> DecidingReading:
    """Return the reading whose error a decision names; without one, that of the largest error.

    Parameters
    ----------
    judged : Assessment
        n >= 1 readings.
    known : Uncertainties
        Of the same readings.
    error_mm : float, optional
        Size of the error that decides.

    Returns
    -------
    DecidingReading
    """
    sizes = np.linalg.norm(judged.identified_mm, axis=1)
    # The nearest one: a stored decision has been through a document and has lost its last bits.
    row = int(np.argmax(sizes) if error_mm is None else np.argmin(np.abs(sizes - error_mm)))
    own, whole = known.covariance[row], known.of_single()[row]
    along = _along(judged.identified_mm[row], whole)
    reading, shared = float(along @ own @ along), float(along @ (whole - own) @ along)
    return DecidingReading(
        int(judged.stops.config[row]),
        float(sizes[row]),
        float(np.sqrt(max(reading, 0.0))),
        float(np.sqrt(max(shared, 0.0))),
    )


def _along(error_mm: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the direction of an error; of none, the worst known one."""
    size = float(np.linalg.norm(error_mm))
    return error_mm / size if size > 0.0 else np.asarray(np.linalg.eigh(covariance)[1][:, -1])
