r"""How much candidates and random functions explain, and whether that is more than noise would give.

*Candidates.* With T the sum of squares that a candidate of k parameters would explain of R, left with nu
degrees of freedom, F = (T / k) / ((R - T) / (nu - k)) is F distributed where the candidate is not there: the
size of the noise is taken from the residuals themselves, never from what is stated. The level is controlled
over everything tried: every cause has the same share of it, divided among its candidates (weighted
Bonferroni). Readings of one stop share what the model lacks there: all counts are divided by the number of
readings that are worth one (design effect, from the residuals themselves). Candidates are compared by BIC;
what was searched over (orders, moments) costs 2 ln of their number.

*Random functions* are many small parameters together, as large as the data ask for. For residuals r of
unknown size with nu degrees of freedom and U = r^T S r / (r^T r / nu), S with eigenvalues l_i, P(U > u) =
P(sum_i (l_i - u / nu) z_i^2 > 0) over nu independent standard normal z_i (l_i = 0 beyond the rank). Its
saddlepoint approximation is accurate far into the tail, where a scaled chi-square is not.

Columns X of a function, each scaled to its prior width, have weights w ~ N(0, v I). Past the parameters that
are fitted they keep the products G = X^T X and b = X^T r. With G = U diag(l) U^T and a_i = (U^T b)_i^2 / l_i,
a ratio t of v to the variance of the noise takes sum_i a_i t l_i / (1 + t l_i) out of the sum of squares R,
and twice the log likelihood gains, the noise profiled out of nu degrees of freedom,

    nu ln(R / R(t)) - sum_i ln(1 + t l_i).

The most likely t is searched on a grid; whether t = 0 could have given the readings is a score test.

References
----------
D. Kuonen, Biometrika 86(4), 1999, 929-935.
R. Lugannani, S. Rice, Advances in Applied Probability 12(2), 1980, 475-490.
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
X. Lin, Biometrika 84(2), 1997, 309-326 (variance-component score tests).
G. A. F. Seber, A. J. Lee, Linear Regression Analysis, 2nd ed., 2003, chapter 4.
C. Genovese, K. Roeder, L. Wasserman, Biometrika 93(3), 2006, 509-524 (weighted Bonferroni).
L. Kish, Survey Sampling, 1965, section 5.4 (design effect).
G. Schwarz, Annals of Statistics 6(2), 1978, 461-464.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from truepose.diagnosis.distributions import f_exceeded, normal_exceeded
from truepose.diagnosis.screening.candidates import View
from truepose.diagnosis.screening.normal_equations import Products, Projection, Sums
from truepose.domain.arrays import FloatArray


def tail_probability(statistic: float, weights: FloatArray, degrees: float) -> float:
    """Return the chance that noise alone exceeds a quadratic form of the residuals.

    P(sum_i (l_i - u / nu) z_i^2 > 0), by the saddlepoint approximation (D. Kuonen, Biometrika 86(4), 1999);
    the nu - k directions beyond the rank of S have l_i = 0.

    Parameters
    ----------
    statistic : float
        u [variance of the noise].
    weights : ndarray, shape (k,)
        Eigenvalues of S, not negative.
    degrees : float
        nu; where there are fewer than weights, as many as weights are counted.

    Returns
    -------
    float
        From 0 to 1; 1 where S is zero. At 1e-7 about a tenth off in the worst case, a single weight (decision
        0015).
    """
    positive = weights[weights > 1e-12 * max(float(weights.max(initial=0.0)), 1e-300)]
    if positive.size == 0:
        return 1.0
    values, multiplicity = positive - statistic / degrees, np.ones(positive.size)
    if degrees > positive.size:
        values = np.append(values, -statistic / degrees)
        multiplicity = np.append(multiplicity, degrees - positive.size)
    # All of one sign: the form cannot reach the statistic, or cannot fall short of it, whatever the noise is.
    if values.max() <= 0.0:
        return 0.0
    if values.min() >= 0.0:
        return 1.0
    return _above_zero(values / np.abs(values).max(), multiplicity)


def _above_zero(values: FloatArray, multiplicity: FloatArray) -> float:
    """Return P(sum of multiplicity * values * z^2 > 0), for values of both signs.

    With K(t) = -1/2 sum m_i ln(1 - 2 t v_i) and K'(t) = 0: w = sign(t) sqrt(-2 K(t)), v = t sqrt(K''(t)) and
    P = 1 - Phi(w + ln(v / w) / w) (R. Lugannani, S. Rice, 1980, in the form of O. E. Barndorff-Nielsen).
    """
    mean = float(multiplicity @ values)
    spread = float(np.sqrt(2.0 * multiplicity @ values**2))
    # At the mean the saddlepoint is t = 0, where w and v vanish and their ratio is rounding.
    if abs(mean) < 1e-6 * spread:
        return 0.5

    def slope(t: float) -> float:
        """Return K'(t)."""
        return float(multiplicity @ (values / (1.0 - 2.0 * t * values)))

    # Beyond these ends of t the generating function does not exist; K' goes to infinity at both, so that a
    # root lies between one of them and 0.
    highest = 0.5 / float(values.max())
    lowest = 0.5 / float(values.min())
    if mean < 0.0:
        t = brentq(slope, 0.0, highest * (1.0 - 1e-9), xtol=1e-12)
    else:
        t = brentq(slope, lowest * (1.0 - 1e-9), 0.0, xtol=1e-12)
    generating = -0.5 * float(multiplicity @ np.log(1.0 - 2.0 * t * values))
    curvature = 2.0 * float(multiplicity @ (values / (1.0 - 2.0 * t * values)) ** 2)
    w = float(np.sign(t) * np.sqrt(max(-2.0 * generating, 0.0)))
    v = t * float(np.sqrt(curvature))
    # Near the mean ln(v / w) / w is a difference of nearly equal numbers; the normal tail is as good there.
    if abs(w) < 1e-3 or abs(v) < 1e-3:
        return float(normal_exceeded(-mean / spread))
    return float(np.clip(normal_exceeded(w + np.log(v / w) / w), 0.0, 1.0))


_RATIOS = np.logspace(-4.0, 6.0, 61)  # of the two variances, over the largest eigenvalue
_SEEN = 1e-9  # of the largest eigenvalue: below, nothing but rounding is seen


@dataclass(frozen=True, slots=True)
class Function:
    """A random function of its most likely size.

    Attributes
    ----------
    width : float
        Standard deviation of its scaled parameters for a fit that counts every reading by itself, 0 where
        none is seen. Where delta readings are worth one (design effect), it is that of the function over the
        root of delta: such a fit takes the mean of a stop for better than it is by that root, and with a
        prior as much narrower it shrinks the function as it should.
    gain : float
        Of twice the log likelihood; minus infinity where nothing can be seen.
    explained : float
        Sum of squares.
    size : float
        Effective number of parameters, sum t l_i / (1 + t l_i).
    """

    width: float
    gain: float
    explained: float
    size: float


_NOTHING = Function(0.0, -np.inf, 0.0, 0.0)


def most_likely(gram: FloatArray, towards: FloatArray, sums: Sums, widest: float = np.inf) -> Function:
    """Fit a random function by maximum likelihood, no larger than physics allows.

    Parameters
    ----------
    gram : ndarray, shape (k, k)
        G, products of its scaled columns past what is fitted.
    towards : ndarray, shape (k,)
        b, their products with the residuals.
    sums : Sums
        Of these residuals.
    widest : float
        What the width of its scaled parameters may be at most.

    Returns
    -------
    Function
        The best of a grid of 61 sizes, six steps a power of ten of the variance; its gain may be negative.
    """
    return most_likely_of(gram[None], towards[None], sums, widest)[0]


def most_likely_of(
    grams: FloatArray, towards: FloatArray, sums: Sums, widest: float = np.inf
) -> list[Function]:
    """Fit C random functions of k parameters, each by itself, as `most_likely` does.

    Parameters
    ----------
    grams : ndarray, shape (C, k, k)
    towards : ndarray, shape (C, k)
    sums : Sums
    widest : float

    Returns
    -------
    list of Function
    """
    sizes, axes = np.linalg.eigh(grams)
    seen = sizes > _SEEN * np.maximum(sizes.max(axis=1, initial=0.0, keepdims=True), 1e-300)
    within = np.einsum("cij,ci->cj", axes, towards) ** 2
    sizes, along = np.where(seen, sizes, 0.0), np.where(seen, within / np.where(seen, sizes, 1.0), 0.0)
    largest = sizes.max(axis=1, initial=0.0, keepdims=True)
    ratios = _RATIOS / np.where(largest > 0.0, largest, 1.0)
    scaled = ratios[:, :, None] * sizes[:, None, :]
    shrunk = scaled / (1.0 + scaled)
    # Rounding may explain a little more than there is; nothing would be left to take the logarithm of.
    most = (1.0 - 1e-9) * sums.residual_square
    explained = np.minimum((shrunk @ along[:, :, None])[:, :, 0], most)
    left = sums.residual_square - explained
    # Readings that repeat one another count once; what the function costs does not depend on how many there
    # are.
    gain = sums.degrees / sums.alike * np.log(sums.residual_square / left) - np.log1p(scaled).sum(axis=2)
    widths = np.sqrt(ratios * left / max(sums.degrees, 1.0))
    # The smallest ratio stays even where it is too wide: argmax over nothing but -inf takes the first.
    best = np.argmax(np.where(widths <= widest, gain, -np.inf), axis=1)
    at = np.arange(len(grams)), best
    told = np.stack([widths[at], gain[at], explained[at], shrunk[at].sum(axis=1)], axis=1).tolist()
    return [
        Function(*one) if any_seen else _NOTHING for one, any_seen in zip(told, seen.any(axis=1), strict=True)
    ]


def chance(gram: FloatArray, towards: FloatArray, sums: Sums) -> float:
    """Return the chance that noise alone lies as much along a random function: score test of t = 0.

    Parameters
    ----------
    gram : ndarray, shape (k, k)
        G, products of its scaled columns past what is fitted.
    towards : ndarray, shape (k,)
        b, their products with the residuals.
    sums : Sums
        Of these residuals.

    Returns
    -------
    float
        P value of U = b^T b over the variance of the residuals; not corrected for what else is tried.

    References
    ----------
    X. Lin, Biometrika 84(2), 1997, 309-326.
    """
    weights = np.maximum(np.linalg.eigvalsh(gram), 0.0)
    statistic = float(towards @ towards) / sums.variance / sums.alike
    return tail_probability(statistic, weights, sums.degrees / sums.alike)


_MOSTLY_BELIEF = 0.1  # what the data see, over what is believed before: below, nothing is seen
_VISIBLE = 1e-7  # share of a derivative's square that the present parameters do not absorb


@dataclass(frozen=True, slots=True)
class Screening:
    """What each of C candidates would do beside what is fitted.

    Attributes
    ----------
    explained : ndarray, shape (C,)
        Sum of squares T.
    size : ndarray, shape (C,)
        Effective number of parameters, 0 where nothing can be seen.
    alone : ndarray, shape (C,)
        P value of each as if nothing else had been tried.
    p_value : ndarray, shape (C,)
        Corrected for everything tried.
    score : ndarray, shape (C,)
        Gain in BIC, search included; larger is better, minus infinity where nothing can be seen.
    width : ndarray, shape (C,)
        Most likely factor on the prior widths of a function; 1 of what is none.
    """

    explained: FloatArray
    size: FloatArray
    alone: FloatArray
    p_value: FloatArray
    score: FloatArray
    width: FloatArray


def screen(view: View) -> Screening:
    """Screen all candidates of a view.

    Parameters
    ----------
    view : View
        Of C candidates.

    Returns
    -------
    Screening
        Of the pool's order; functions by their likelihood and score test, all others by F test and BIC.
    """
    screened, pool = _screened(view), view.pool
    for index in pool.functions:
        candidate = pool.all[index]
        if not view.fitted.isdisjoint(candidate.names):
            continue  # what its prior holds back of a fitted function is no function once more
        gram, towards = _of_function(view, index)
        # A curve that was sized may grow again, but no farther than it was proposed with: gears are not
        # worse.
        found = most_likely(gram, towards, view.sums, widest=1.0 / candidate.size)
        screened.explained[index], screened.size[index] = found.explained, found.size
        screened.width[index] = found.width
        # No ln n for each parameter: the likelihood is integrated over them already, which ln(1 + t l) pays
        # for.
        screened.score[index] = found.gain - 2.0 * np.log(pool.tried[index])
        screened.alone[index] = chance(gram, towards, view.sums)
        screened.p_value[index] = min(1.0, pool.shares[index] * screened.alone[index])
    return screened


def _of_function(view: View, index: int) -> tuple[FloatArray, FloatArray]:
    """Return products among the columns of a function, scaled to its prior widths, past what is fitted.

    Shapes (k, k) and (k,): G, and b with the residuals.
    """
    widths = np.array([spec.prior_width for spec in view.pool.all[index].specs])
    return view.gram(index) * np.outer(widths, widths), view.towards[view.pool.own(index)] * widths


def _screened(view: View) -> Screening:
    """Screen the candidates that are no functions."""
    sums, pool = view.sums, view.pool
    alike = sums.alike
    explained, size = _explained(view)
    # Never 0: a candidate that explains everything would divide by it.
    left = np.maximum(sums.residual_square - explained, 1e-9 * sums.residual_square + 1e-300)
    # Of readings that are worth one (design effect). T and R are sums over all readings, so the effect
    # cancels in their ratio and is left in the degrees alone.
    degrees = np.maximum(sums.degrees / alike - size, 1.0)
    seen = size > 0
    ratio = np.where(seen, explained / np.maximum(size, 1), 0.0) / (left / degrees)
    alone = np.where(seen, f_exceeded(ratio, np.maximum(size, 1), degrees), 1.0)
    likelihood = sums.degrees / alike * np.log(sums.residual_square / left)
    score = likelihood - size * np.log(max(sums.observations / alike, 2.0)) - 2.0 * np.log(pool.tried)
    return Screening(
        explained=explained,
        size=size,
        alone=alone,
        p_value=np.minimum(alone * pool.shares, 1.0),
        score=np.where(seen, score, -np.inf),
        width=np.ones(len(pool.all)),
    )


def chance_beside(products: Products, widths: FloatArray, past: Projection, tried: int) -> float:
    """Return the chance, over everything tried, that noise gives what columns explain past what is fitted.

    The F test of the head of this module, for columns that belong to no pool.

    Parameters
    ----------
    products : Products
        Of k columns with the fit.
    widths : ndarray, shape (k,)
        Of the priors of their parameters.
    past : Projection
        Past what is fitted.
    tried : int
        By what the p value is multiplied (Bonferroni).

    Returns
    -------
    float
        1 where none of the columns can be seen.
    """
    absorbed = past.absorbed(products)
    rows, sums = products.columns, past.sums
    scale = np.sqrt(np.maximum(np.einsum("km,km->k", rows, rows), 1e-300))
    gram = (rows @ rows.T - absorbed @ absorbed.T) / np.outer(scale, scale)
    towards = past.towards(products, absorbed) / scale
    explained, size = _quadratic(gram[None], (1.0 / (widths * scale) ** 2)[None], towards[None])
    if size[0] == 0.0:
        return 1.0
    degrees = max(sums.degrees / sums.alike - size[0], 1.0)
    left = max(sums.residual_square - explained[0], 1e-300)
    ratio = explained[0] / size[0] / (left / degrees)
    return min(1.0, tried * float(f_exceeded(ratio, size[0], degrees)))


def _explained(view: View) -> tuple[FloatArray, FloatArray]:
    """Return what each of C candidates explains, and its number of visible parameters, shape (C,) each.

    Functions are left at 0.
    """
    explained, size = np.zeros(len(view.pool.all)), np.zeros(len(view.pool.all))
    for alike in view.pool.alike:
        taken = view.absorbed[alike.rows] / alike.scale[:, :, None]
        gram = alike.gram - taken @ np.swapaxes(taken, 1, 2)
        found = _quadratic(gram, alike.belief, view.towards[alike.rows] / alike.scale)
        explained[alike.here], size[alike.here] = found
    return explained, size


def _quadratic(gram: FloatArray, belief: FloatArray, towards: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the sum of squares explained, and the number of parameters that can be seen, of C candidates.

    With G = U diag(l) U^T of unit columns and B the precision of the priors, T = sum (U^T b)_j^2 / (l_j +
    B_j), B_j = sum_i U_ij^2 B_i, over the visible directions j. The prior of each parameter is an observation
    of it: an amplitude that nobody would believe explains nothing. A direction that the data see less well
    than the prior knows it does not count.

    Parameters
    ----------
    gram : ndarray, shape (C, k, k)
        Of unit columns, past what is fitted.
    belief : ndarray, shape (C, k)
        Precisions of the priors, in units of the unit columns.
    towards : ndarray, shape (C, k)
        b, products of the unit columns with the residuals.

    Returns
    -------
    tuple of ndarray, shape (C,)
        T and the number of parameters.
    """
    sizes, axes = np.linalg.eigh(gram)
    # What the present parameters absorb to a ten-millionth is the rounding of their own projection.
    seen = sizes > _VISIBLE
    within = np.einsum("cij,ci->cj", axes, towards)
    strength = np.einsum("cij,ci->cj", axes**2, belief)
    explained = np.where(seen, within**2 / np.where(seen, sizes + strength, 1.0), 0.0).sum(axis=1)
    return explained, (seen & (sizes > _MOSTLY_BELIEF * strength)).sum(axis=1).astype(float)
