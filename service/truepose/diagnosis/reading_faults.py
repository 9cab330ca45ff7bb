"""Faults of readings: swapped labels, outliers that share something, heavy-tailed noise.

Heavy tails are noise: what is left follows Student's t better than a normal distribution with a few wild
readings besides (mixture). Readings are called bad only where the mixture is clearly the better story. With q
the squared residual of d components, their log densities are

    normal   ln chi2_d(q / v) - ln v,        v = mean(q) / d
    Student  ln Gamma((nu + d)/2) - ln Gamma(nu/2) - ln Gamma(d/2) - (d/2) ln(nu s)
             + (d/2 - 1) ln q - (nu + d)/2 ln(1 + q / (nu s))
    mixture  ln((1 - p) normal(q; v1) + p normal(q; v2)),

the last two at their most likely parameters.

What bad readings share may be their cause. A beam that was brushed or a reflector that was not seated spoils
readings anywhere. Where more of the bad ones than chance gives (hypergeometric tail) are of one nest, of one
mounting, or of one part of the campaign or of a joint's range, they are not bad one by one.

References
----------
K. L. Lange, R. J. A. Little, J. M. G. Taylor, J. American Statistical Association 84, 1989, 881-896.
H. Akaike, IEEE Trans. Automatic Control 19(6), 1974, 716-723 (one unit a parameter).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.special import gammaln

from truepose.diagnosis.distributions import chi2_log_density, hypergeometric_tail
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import PointReadings
from truepose.effects.causes import Scene, has_spread
from truepose.effects.motions import spoken
from truepose.effects.names import joint_subject
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.messages.message import Message, message

_FITS = 0.2  # another nest must leave less than this share of the residual
_CLEARLY = 5.0  # in log likelihood
_HARDLY = 1.5  # in log likelihood: the others show no heavy tails
_FAR_BEYOND = 150.0  # of the usual variance, twelve standard deviations: t noise of 4 degrees once in 10,000
_MOST_DEGREES = 30.0  # Student's t beyond is normal for all that a campaign can tell


def swapped_labels(points: PointReadings, suspect: BoolArray, model: RobustFit) -> IntArray:
    """Return the nest that each reading fits: another than its own only where that explains a suspect one.

    Parameters
    ----------
    points : PointReadings
        n readings.
    suspect : ndarray, shape (n,)
    model : RobustFit
        Whose predictions are compared.

    Returns
    -------
    ndarray, shape (n,)
        1-based nests.
    """
    nest = points.nest.copy()
    rows = np.flatnonzero(suspect)
    numbers = range(1, len(model.structure.nests_mm) + 1)
    if rows.size == 0 or len(numbers) < 2:
        return nest
    # A suspect reading is tried at every nest, its own too: it must fit another one five times better.
    distances = np.stack([_distance(points, rows, number, model) for number in numbers])
    own = distances[points.nest[rows] - 1, np.arange(rows.size)]
    best = np.argmin(distances, axis=0)
    better = distances[best, np.arange(rows.size)] < _FITS * own
    nest[rows[better]] = best[better] + 1
    return nest


def _distance(points: PointReadings, rows: IntArray, number: int, model: RobustFit) -> FloatArray:
    """Return how far readings (r,) lie from where a nest is predicted, shape (r,) [mm]."""
    asked = Targets(points.stops.taken(rows), np.full(rows.size, number))
    predicted = evaluate(model.structure, model.values, asked).position_mm
    return np.asarray(np.linalg.norm(points.position_mm[rows] - predicted, axis=1))


@dataclass(frozen=True, slots=True)
class Tails:
    """How the squared normalised residuals of n readings of d components are distributed.

    Attributes
    ----------
    bad : ndarray of bool, shape (n,)
        Readings that belong to no model; none where tails are merely heavy.
    degrees_of_freedom : float or None
        Of Student's t where the tails are heavy.
    """

    bad: BoolArray
    degrees_of_freedom: float | None


def tails(squared: FloatArray, components: int, gross: BoolArray) -> Tails:
    """Judge the tails of the residuals.

    Parameters
    ----------
    squared : ndarray, shape (n,)
        Squared residual of each reading in its own covariance.
    components : int
        d.
    gross : ndarray of bool, shape (n,)
        Readings that the fit gave no weight.

    Returns
    -------
    Tails
        Bad are those that the fit gave no weight, or none at all.
    """
    none = np.zeros(len(squared), dtype=bool)
    squared = np.maximum(squared, 1e-12)  # a reading that lies on the model has no logarithm
    if _stand_apart(squared, components, gross):
        return Tails(gross, None)
    normal = _normal(squared, components)
    student, degrees = _student(squared, components)
    mixed = _mixture(squared, components)
    if gross.any() and mixed - max(normal, student) > _CLEARLY:
        return Tails(gross, None)
    heavy = student - normal > _CLEARLY and degrees < _MOST_DEGREES
    return Tails(none, degrees if heavy else None)


def _stand_apart(squared: FloatArray, components: int, gross: BoolArray) -> bool:
    """Whether gross readings lie so far beyond others that scatter normally that no tail reaches there."""
    if not gross.any() or gross.all():
        return False
    usual = squared[~gross]
    typical = float(usual.mean()) / components
    if float(squared[gross].min()) < _FAR_BEYOND * typical:
        return False
    # The others must be normal by themselves: heavy-tailed noise has readings as far out.
    student, _ = _student(usual, components)
    return student - _normal(usual, components) < _HARDLY


def _log_chi2(squared: FloatArray, components: int, variance: float) -> FloatArray:
    """Return the log density of squared residuals (n,) whose components have this variance, shape (n,)."""
    return np.asarray(chi2_log_density(squared / variance, components) - np.log(variance))


def _normal(squared: FloatArray, components: int) -> float:
    """Return the largest log likelihood of normal noise."""
    # Readings without any error are perfect, not impossible: their variance stays above 0.
    variance = max(float(squared.mean()) / components, 1e-12)
    return float(_log_chi2(squared, components, variance).sum())


def _student(squared: FloatArray, components: int) -> tuple[float, float]:
    """Return the largest log likelihood of Student's t, and its degrees of freedom.

    The squared radius of a multivariate t of d components with scale s and nu degrees of freedom.
    """
    d = components

    def negative(p: FloatArray) -> float:
        """Return minus the log likelihood; the logarithms of scale and degrees keep both above 0."""
        scale, nu = np.exp(p[0]), np.exp(p[1])
        constant = gammaln((nu + d) / 2) - gammaln(nu / 2) - gammaln(d / 2) - d / 2 * np.log(nu * scale)
        kernel = (d / 2 - 1) * np.log(squared) - (nu + d) / 2 * np.log1p(squared / (nu * scale))
        return -float((constant + kernel).sum())

    start = np.array([np.log(max(float(np.median(squared)) / d, 1e-12)), np.log(5.0)])
    found = minimize(negative, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3})
    return -float(found.fun), float(np.exp(found.x[1]))


def _mixture(squared: FloatArray, components: int) -> float:
    """Return the largest log likelihood of normal noise with a share of wild readings, less one.

    One parameter more than Student's t has costs one unit (Akaike).
    """
    typical = max(float(np.median(squared)) / components, 1e-12)
    largest = max(float(squared.max()) / components, 4.0 * typical)

    def negative(p: FloatArray) -> float:
        """Return minus the log likelihood by log odds and the logarithms of both variances."""
        # the share of wild readings by its log odds p[0]: both logarithms stay finite
        usual = _log_chi2(squared, components, float(np.exp(p[1]))) - np.logaddexp(0.0, p[0])
        wild = _log_chi2(squared, components, float(np.exp(p[2]))) - np.logaddexp(0.0, -p[0])
        return -float(np.logaddexp(usual, wild).sum())

    start = np.array([-3.0, np.log(typical), np.log(largest / 2.0)])
    found = minimize(negative, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3})
    return -float(found.fun) - 1.0


_LEVEL = 0.01  # chance that bad readings which fell anywhere gather, over everything that they may share
_PARTS = 4  # of the campaign, or of a joint's range, with as many readings in each


class Variable(NamedTuple):
    """A variable that readings may depend on, in the words of the families."""

    variable: str
    kind: str
    joint: int | None = None  # 0-based


class OutlierCluster(NamedTuple):
    """What bad readings share.

    Attributes
    ----------
    on : Variable
    p_value : float
        Corrected for everything that they may share.
    sentence : Message
    """

    on: Variable
    p_value: float
    sentence: Message


class _Shared(NamedTuple):
    """Readings that have something in common.

    Attributes
    ----------
    words : Message
    on : Variable
    readings : ndarray of bool, shape (n,)
    by_stop : bool
        All readings of a stop have it in common: they count once.
    """

    words: Message
    on: Variable
    readings: BoolArray
    by_stop: bool


def shared_properties(scene: Scene, bad: BoolArray) -> OutlierCluster | None:
    """Return what the bad readings share beyond chance.

    Parameters
    ----------
    scene : Scene
        Of n readings.
    bad : ndarray of bool, shape (n,)

    Returns
    -------
    OutlierCluster or None
        None where they may have fallen anywhere.
    """
    everything = tuple(_shareable(scene)) if bad.any() else ()
    chances = [len(everything) * _chance(scene.stops.config, bad, one) for one in everything]
    p_value, nearest = min(zip(chances, range(len(chances)), strict=True), default=(1.0, 0))
    if p_value > _LEVEL:
        return None
    shared = everything[nearest]
    sentence = message(
        "gathered",
        bad=int((bad & shared.readings).sum()),
        shared=shared.words,
        readings=int(shared.readings.sum()),
    )
    return OutlierCluster(shared.on, p_value, sentence)


def _chance(config: IntArray, bad: BoolArray, shared: _Shared) -> float:
    """Return the chance that at least as many of the bad ones share it where they fall anywhere."""
    marked = shared.readings
    if shared.by_stop:
        # A stop that was read at three nests while something was loose is one misfortune, not three.
        _, first = np.unique(config, return_index=True)
        bad, marked = np.isin(config[first], config[bad]), marked[first]
    return hypergeometric_tail(int((bad & marked).sum()), int(bad.sum()), int(marked.sum()), len(bad))


def _shareable(scene: Scene) -> Iterator[_Shared]:
    """Yield everything that readings may share."""
    yield from _nests(scene)
    time_s, turns_deg = scene.stops.time_s, np.rad2deg(scene.stops.joints_rad.T)
    if time_s is not None and has_spread(time_s):
        yield from _times(time_s - scene.origin_s)
    for joint, turn_deg in enumerate(turns_deg):
        yield from _angles(joint, turn_deg)


def _nests(scene: Scene) -> Iterator[_Shared]:
    """Yield nests, mountings of the tool, and each nest in each mounting."""
    mounting, nests = scene.stops.attachment, np.unique(scene.nest).tolist()
    for nest in nests:
        yield _Shared(
            message("gathered.nest", nest=nest), Variable("nest", "nest"), scene.nest == nest, by_stop=False
        )
    if mounting is None:
        return
    for number in np.unique(mounting).tolist():
        words, mounted = message("gathered.mounting", mounting=number), mounting == number
        yield _Shared(words, Variable("attachment of the tool", "attachment"), mounted, by_stop=True)
        for nest in nests:
            both = Variable("nest and attachment of the tool", "attachment")
            words = message("gathered.nest_and_mounting", nest=nest, mounting=number)
            yield _Shared(words, both, mounted & (scene.nest == nest), by_stop=False)


def _times(time_s: FloatArray) -> Iterator[_Shared]:
    """Yield the parts of a campaign, times (n,) [s] from its origin."""
    for low, high, within in _parts(time_s):
        words = message("gathered.time", low=spoken(low), high=spoken(high))
        yield _Shared(words, Variable("time", "time"), within, by_stop=True)


def _angles(joint: int, turn_deg: FloatArray) -> Iterator[_Shared]:
    """Yield the parts of a joint's range, angles (n,) [deg]."""
    name = joint_subject(joint)
    for low, high, within in _parts(turn_deg):
        words = message("gathered.angle", joint=name, low_deg=low, high_deg=high)
        yield _Shared(words, Variable(f"angle of {name}", "angle", joint), within, by_stop=True)


def _parts(values: FloatArray) -> Iterator[tuple[float, float, BoolArray]]:
    """Yield the ends of each part of a range, and the readings within.

    Parts hold as many readings each, so that each has the same chance; readings without a value are in none.
    """
    edges = np.nanquantile(values, np.linspace(0.0, 1.0, _PARTS + 1))
    for part, (low, high) in enumerate(pairwise(edges.tolist())):
        last = part == _PARTS - 1
        yield low, high, (values >= low) & (values <= high if last else values < high)
