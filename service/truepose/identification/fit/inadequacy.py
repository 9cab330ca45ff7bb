r"""Model inadequacy: random functions of each joint beside a fitted model, as large as the residuals ask for.

Whatever a model leaves out moves joints, and the tool by their levers: gaps turn with the direction of
approach, gears and bearings with the angle, springs with the torque. Such functions G b, those of a joint and
kind with one variance, b ~ N(0, v), stand beside the fitted parameters. Past these, whose derivatives are J
and whose covariance is C, they keep of themselves and of the residuals r

    A = G G^T - G J^T C J G^T        y = G r

and K = C J G^T is what the parameters take over of each. The variances and the noise s^2 maximise the
marginal likelihood:

    B = (A / s^2 + 1 / v)^-1        b = B y / s^2        v <- |b|^2 / (k - tr B / v)

for k functions of one variance. Where functions can explain all that the parameters leave, no likelihood
bounds s^2 from below: what readings state of their noise then counts as one reading more. What even they
leave of the residuals, beyond what readings state, is the rest: of no shape, and the same everywhere.

In the code G is `white` (c functions, whitened, in units of their prior width), A is `squares`, y is
`towards`, K is `absorbed`, v is `variance`, s^2 is `noise` (over the variance by which readings were
weighed), and k - tr B / v is the sum of `told`: how many functions' worth the readings tell.

References
----------
D. J. C. MacKay, Neural Computation 4(3), 1992, 415-447 (the iteration).
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
"""

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, Self

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.identification import ModelInadequacy, Parameter
from truepose.domain.singular_covariance import whitening_root
from truepose.effects.ports import Setting
from truepose.effects.registry import effect_named, unmodelled_in
from truepose.identification.fit.robust import RobustFit, degrees_of_freedom
from truepose.identification.model.prediction import Function, function_columns, shortfall_variance
from truepose.identification.observations.poses import PositionBlock

_ROUNDS: Final = 40
_NONE: Final = 1e-12  # variance, over what is believed, of a function that is not there
_TOLD: Final = 0.5  # of a group, that must come from the readings and not from what was expected of it
_FELT: Final = 1e-2  # standard deviations of a reading, by which what is as large as believed moves some
_ROUNDING: Final = 1e-11  # of a function's square: as much is left where the parameters take it over wholly
_LEAST_FREE: Final = 0.05  # of the readings: parameters and functions never take all of them


class _Found(NamedTuple):
    """How large functions are, c of them."""

    mean: FloatArray  # (c,)
    covariance: FloatArray  # (c, c)
    noise: float  # variance of what they leave, over that of the weights
    told: FloatArray  # (c,) how much of each the readings tell, 0 to 1


def shortfall(fit: RobustFit, setting: Setting) -> ModelInadequacy | None:
    """Return what a model of positions lacks; None of other readings.

    Parameters
    ----------
    fit : RobustFit
        Of positions in its first block, at the weights that it settled on.
    setting : Setting
        Of the campaign: it tells which functions may be there.

    Returns
    -------
    ModelInadequacy or None
        Functions in their internal units with their covariance, and the rest [mm] per axis. Without
        functions where the readings show none; None where lengths were read.
    """
    if not isinstance(fit.blocks[0], PositionBlock):
        return None
    tried = _Tried.of(fit, _functions(fit, setting))
    variance, noise = tried.most_likely()
    kept = tried.shown(variance, noise)
    return _told(fit, tried.taken(kept), variance[kept], noise)


def typical_mm(found: ModelInadequacy, fit: RobustFit) -> float:
    """Return the root mean square per axis of what a model lacks at its own readings [mm].

    Parameters
    ----------
    found : ModelInadequacy
        Of that fit.
    fit : RobustFit
    """
    result = fit.results[0]
    return float(np.sqrt(shortfall_variance(found, result.state, result.jacobian).mean()))


def _functions(fit: RobustFit, setting: Setting) -> tuple[Function, ...]:
    """Return what such readings may show and is not in the model."""
    known = set(fit.structure.names)
    return tuple(
        Function(kind, spec)
        for kind in unmodelled_in(setting, fit.blocks[0].targets.stops)
        for spec in effect_named(kind).specs(setting)
        if spec.name not in known
    )


@dataclass(frozen=True, slots=True)
class _Tried:
    """c functions past the P parameters of a fit, in units of what is believed of each."""

    functions: tuple[Function, ...]
    group: IntArray  # (c,) those of one kind and joint have one number
    columns: FloatArray  # (c, n, 3) how they move the nests [mm]
    absorbed: FloatArray  # (P, c)
    squares: FloatArray  # (c, c)
    towards: FloatArray  # (c,)
    residual_square: float
    degrees: float  # of freedom of the residuals

    @classmethod
    def of(cls, fit: RobustFit, functions: tuple[Function, ...]) -> Self:
        """Return the functions that move some reading as no parameter does, at a fit.

        A nest on the axis of a joint is moved by rounding alone, and would let any size be believed; so would
        what the parameters take over wholly.
        """
        result, covariance = fit.results[0], fit.solution.covariance
        columns, joint = function_columns(functions, result.state)
        # In units of what is believed of each, functions of angles, torques and directions are comparable.
        columns *= np.array([one.spec.prior_width for one in functions]).reshape(-1, 1, 1)
        white = result.whitening.apply(columns).reshape(len(functions), result.residual.size)
        across, residual = result.white_jacobian @ white.T, result.white_residual
        absorbed = covariance @ across
        own = white @ white.T
        squares = own - across.T @ absorbed
        effects = [one.effect for one in functions]
        kinds = list(dict.fromkeys(effects))
        tried = cls(
            functions=functions,
            group=len(kinds) * joint + np.array([kinds.index(one) for one in effects], dtype=np.int64),
            columns=columns,
            absorbed=absorbed,
            squares=(squares + squares.T) / 2.0,  # the parameters leave 8 digits of its symmetry
            towards=white @ residual,
            residual_square=float(residual @ residual),
            degrees=degrees_of_freedom(fit.blocks[0], result, covariance),
        )
        felt = np.abs(white).max(axis=1, initial=0.0) > _FELT
        return tried.taken(np.flatnonzero(felt & (np.diag(squares) > _ROUNDING * np.diag(own))))

    def taken(self, kept: IntArray) -> Self:
        """Return some of the functions."""
        return replace(
            self,
            functions=tuple(self.functions[k] for k in kept.tolist()),
            group=self.group[kept],
            columns=self.columns[kept],
            absorbed=self.absorbed[:, kept],
            squares=self.squares[np.ix_(kept, kept)],
            towards=self.towards[kept],
        )

    def most_likely(self) -> tuple[FloatArray, float]:
        """Return the variances of the functions, shape (c,), and that of the noise."""
        # From what is believed: from 0 no step of this iteration would ever lead away.
        variance, noise = np.ones(len(self.functions)), 1.0
        for _ in range(_ROUNDS):
            found = self.found(variance, noise)
            square, told = np.bincount(self.group, found.mean**2), np.bincount(self.group, found.told)
            # One variance a group: a single function has too little to tell its own size from chance.
            variance = np.maximum(square / np.maximum(told, _NONE), _NONE)[self.group]
            noise = found.noise
        return variance, noise

    def found(self, variance: FloatArray, noise: float) -> _Found:
        """Return the functions of given variances beside given noise.

        Parameters
        ----------
        variance : ndarray, shape (c,)
            v, over what is believed of each.
        noise : float
            s^2, over the variance by which the readings were weighed.
        """
        root = np.sqrt(variance)
        # In units of the roots of v the matrix is at least 1 along every direction, whatever v has gone to 0.
        half = whitening_root(self.squares * np.outer(root, root) / noise + np.eye(len(root)))
        unit = half.T @ half
        covariance = unit * np.outer(root, root)
        mean = covariance @ self.towards / noise
        told = 1.0 - np.diag(unit)
        left = self.residual_square - 2.0 * float(mean @ self.towards) + float(mean @ self.squares @ mean)
        least = 1.0 / (1.0 + self.degrees)
        return _Found(mean, covariance, max(left / max(self.degrees - told.sum(), 1.0), least), told)

    def shown(self, variance: FloatArray, noise: float) -> IntArray:
        """Return which functions are of a group that the readings tell more of than chance would."""
        told = np.bincount(self.group, self.found(variance, noise).told)
        return np.flatnonzero((told > _TOLD * np.bincount(self.group))[self.group])


def _told(fit: RobustFit, tried: _Tried, variance: FloatArray, noise: float) -> ModelInadequacy:
    found = tried.found(variance, noise)
    believed = np.array([one.spec.prior_width for one in tried.functions])
    # Back from units of what is believed to those of each function.
    covariance = found.covariance * np.outer(believed, believed)
    means, spreads = (found.mean * believed).tolist(), np.sqrt(np.diag(covariance)).tolist()
    widths = (np.sqrt(variance) * believed).tolist()
    return ModelInadequacy(
        functions=tuple(
            Parameter(spec.name, effect, mean, spec.unit, spread, width)
            for (effect, spec), mean, spread, width in zip(
                tried.functions, means, spreads, widths, strict=True
            )
        ),
        covariance=covariance,
        absorbed=tried.absorbed / believed,
        rest_mm=_rest_mm(fit, tried, found),
    )


def _rest_mm(fit: RobustFit, tried: _Tried, found: _Found) -> float:
    """Return the standard deviation per axis of what remains of the readings that count.

    0 where it is within one standard deviation of what the readings state: chance leaves as much.
    """
    block, result = fit.blocks[0], fit.results[0]
    moved = tried.columns - np.tensordot(tried.absorbed.T, result.jacobian, 1)
    left, counts = result.residual - np.tensordot(found.mean, moved, 1), ~fit.gross[0]
    degrees = max(tried.degrees - found.told.sum(), 1.0)
    # Residuals are smaller than errors by what parameters and functions absorbed.
    free = max(degrees / (block.weights.sum() * block.components), _LEAST_FREE)
    # Without the discrepancy that the fit has added: that is what is asked for.
    stated = block.weighted(block.weights, 0.0).component_variance() + block.scatter_mm**2
    variance = float((left[counts] ** 2).mean() / free)
    beyond = variance - float(stated[counts].mean())
    # sqrt(2 / k) of itself is the standard deviation of a variance with k degrees of freedom.
    return float(np.sqrt(beyond)) if beyond > np.sqrt(2.0 / degrees) * variance else 0.0
