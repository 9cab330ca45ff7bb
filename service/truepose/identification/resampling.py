r"""How far parameters scatter, found by fitting again and again: by noise, or by configurations.

A covariance is what a linear model with noise as stated says of its parameters. Two ways to ask more:

*Noise* is the Monte Carlo of an uncertainty (JCGM 101:2008): the whitened readings and the means of the
priors are moved by draws of unit variance, and what minimises

    || r(theta) + e ||^2 + || (theta - mu - W n) / W ||^2          e, n ~ N(0, 1)

is a draw of the parameters. Where the model is linear these are exactly draws of the posterior, so that their
covariance is the one that is stated; where they differ, the model is not linear within its uncertainty
(randomize-then-optimize: J. M. Bardsley, A. Solonen, H. Haario, M. Laine, SIAM J. Sci. Comput. 36(4), 2014,
A1895-A1910, without its weights).

*Configurations* are drawn with replacement, all readings of one together, and priors stay (bootstrap of
pairs, in groups: B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993, section 9.5;
A. C. Davison, D. V. Hinkley, Bootstrap Methods and their Application, 1997, section 3.8). It asks nothing of
the noise: what the model lacks scatters the parameters as it does. Parameters that their prior holds scatter
less than their uncertainty, as a prior is no reading.

Which readings are gross, and what the model lacks, was decided once and is not decided again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Unit
from truepose.effects.registry import chosen_effects
from truepose.identification.fit.robust import RobustFit, robust_fit
from truepose.identification.fit.solver import solve
from truepose.identification.observations.blocks import ObservationBlock, StackedBlocks, linearise_blocks
from truepose.identification.problem.build import automatic_effects, build
from truepose.identification.verdict.outliers import within_reach

Way = Literal["noise", "configurations"]
FEWEST: Final = 10  # draws, and configurations, below which a spread says nothing
_LEVEL: Final = 0.95


@dataclass(frozen=True, slots=True)
class ParameterSpread:
    """How a parameter scattered over the draws, in its own unit.

    Attributes
    ----------
    name, effect, unit : str
    value : float
        Of the fit.
    standard_uncertainty : float
        Of the fit, from its readings and priors.
    standard_deviation : float
        Of the draws.
    bias : float
        Mean of the draws less the value.
    interval_95 : tuple of float, length 2
        The 2.5 % and 97.5 % quantiles of the draws.
    """

    name: str
    effect: str
    unit: Unit
    value: float
    standard_uncertainty: float
    standard_deviation: float
    bias: float
    interval_95: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Spread:
    """How all parameters scattered.

    Attributes
    ----------
    way : str
        "noise" or "configurations".
    draws : int
        That converged.
    not_converged : int
        Draws that were left out.
    parameters : tuple of ParameterSpread
    """

    way: Way
    draws: int
    not_converged: int
    parameters: tuple[ParameterSpread, ...]


class Resampling:
    """A fit that is made again with other noise, or with other configurations."""

    def __init__(self, campaign: Campaign, effects: tuple[str, ...] | None = None) -> None:
        """Fit a campaign.

        Parameters
        ----------
        campaign : Campaign
        effects : tuple of str, optional
            As of `identify`.

        Raises
        ------
        UnknownEffectError, ConfigurationError
            The request cannot be understood, or the campaign has nothing to identify from.
        """
        chosen = automatic_effects(campaign) if effects is None else chosen_effects(effects)
        # Readings out of reach stay aside in every draw, as they do in the identification.
        problem = build(within_reach(campaign).campaign, chosen)
        self.fitted: RobustFit = robust_fit(problem.structure, problem.blocks, problem.start)

    def draw(self, way: Way, rng: np.random.Generator) -> FloatArray | None:
        """Return the parameters of one draw.

        Parameters
        ----------
        way : str
            "noise" or "configurations".
        rng : Generator
            Its state alone decides the draw.

        Returns
        -------
        ndarray, shape (P,), or None
            Internal units; None where the fit of the draw did not converge.

        Raises
        ------
        ConfigurationError
            Configurations are to be drawn, and there are fewer than ten.
        """
        return self._with_noise(rng) if way == "noise" else self._with_configurations(rng)

    def spread(self, way: Way, drawn: Sequence[FloatArray | None]) -> Spread:
        """Return how the parameters of many draws scatter.

        Parameters
        ----------
        way : str
            By which they were drawn.
        drawn : sequence of ndarray, shape (P,), or None
            As `draw` gives them.

        Raises
        ------
        ConfigurationError
            Fewer than ten draws converged.
        """
        kept = [values for values in drawn if values is not None]
        if len(kept) < FEWEST:
            raise ConfigurationError(
                f"Only {len(kept)} of {len(drawn)} draws converged; at least {FEWEST} are needed. Request "
                "more draws."
            )
        return Spread(way, len(kept), len(drawn) - len(kept), self._parameters(np.array(kept)))

    def _with_noise(self, rng: np.random.Generator) -> FloatArray | None:
        structure, blocks = self.fitted.structure, self.fitted.blocks
        noise = rng.standard_normal(len(self.fitted.solution.final.residual))
        # Priors are moved as readings are: otherwise what they hold would not scatter at all.
        means = structure.prior_means + structure.prior_widths * rng.standard_normal(len(structure.specs))

        def moved(values: FloatArray, previous: StackedBlocks | None) -> StackedBlocks:
            point = linearise_blocks(structure, blocks, values, previous)
            return replace(point, residual=point.residual + noise)

        # From the fit: a draw is a standard uncertainty or two away.
        solution = solve(moved, self.fitted.values, means, structure.prior_widths)
        return solution.values if solution.converged else None

    def _with_configurations(self, rng: np.random.Generator) -> FloatArray | None:
        structure = self.fitted.structure
        of_arm = [block for block in self.fitted.blocks if block.of_arm]
        # Whole configurations: their readings share the scatter of one stop and what the model lacks there.
        configurations = np.unique(np.concatenate([block.targets.stops.config for block in of_arm]))
        if len(configurations) < FEWEST:
            raise ConfigurationError(
                f"The campaign has {len(configurations)} configurations; resampling them needs at least "
                f"{FEWEST}. Resample the noise instead."
            )
        drawn = rng.choice(configurations, len(configurations))
        # Sides, distances and fixed nests belong to no configuration and are there in every draw.
        blocks = tuple(_drawn(block, drawn) if block.of_arm else block for block in self.fitted.blocks)
        solution = solve(
            lambda values, previous: linearise_blocks(structure, blocks, values, previous),
            self.fitted.values,
            structure.prior_means,
            structure.prior_widths,
        )
        return solution.values if solution.converged else None

    def _parameters(self, drawn: FloatArray) -> tuple[ParameterSpread, ...]:
        structure, values = self.fitted.structure, self.fitted.values
        stated = np.sqrt(np.diag(self.fitted.solution.covariance))
        tail = (1.0 - _LEVEL) / 2.0
        # Quantiles, not a multiple of the deviation: what is not linear need not scatter evenly.
        low, high = np.quantile(drawn, [tail, 1.0 - tail], axis=0)
        scatter, bias = drawn.std(axis=0, ddof=1), drawn.mean(axis=0) - values
        return tuple(
            ParameterSpread(
                spec.name,
                owner,
                spec.unit,
                float(values[k]),
                float(stated[k]),
                float(scatter[k]),
                float(bias[k]),
                (float(low[k]), float(high[k])),
            )
            for k, (spec, owner) in enumerate(zip(structure.specs, structure.owners, strict=True))
        )


def _drawn(block: ObservationBlock, configurations: IntArray) -> ObservationBlock:
    """Return the readings of configurations that were drawn; one drawn twice is two of them."""
    config = block.targets.stops.config
    rows = [np.flatnonzero(config == one) for one in configurations]
    # Two of one configuration must not share the scatter of one stop: each is numbered anew.
    again = np.repeat(np.arange(len(rows)), [len(own) for own in rows])
    taken = block.taken(np.concatenate(rows))
    # Weights and discrepancy were decided once, and go with the readings.
    stops = replace(taken.targets.stops, config=again)
    return replace(taken, targets=replace(taken.targets, stops=stops)).weighted(
        taken.weights, taken.discrepancy
    )
