"""Residual structure: what the errors left over depend on, or noise and of which kind.

Every family is tested as a random effect on the residuals (score test of a variance component, formulas at
`screening.significance`); the level is controlled over all families (Bonferroni). The noise is not known: its
size is taken from the residuals themselves.

Fixed nests stand still: what moves them in time is the instrument. A model that they contradict lacks
something that runs or happens in time, and what it says of the base or of a joint over time may be that. Such
a finding is not certain, and the same of the instrument is its rival (decision 0029).
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.angle_steps import AngleSteps, telling_steps
from truepose.diagnosis.baseline_fit import Start
from truepose.diagnosis.distributions import chi2_log_density
from truepose.diagnosis.reading_faults import Tails, tails
from truepose.diagnosis.screening.candidates import pool_candidates, term_columns
from truepose.diagnosis.screening.normal_equations import Products, Projection, products_of
from truepose.diagnosis.screening.selection import LEVEL, Selection
from truepose.diagnosis.screening.significance import chance, most_likely, screen
from truepose.diagnosis.screening.smooth_functions import Family, families, terms_of
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause, Gain, WorstPoint
from truepose.effects.causes import Candidate, ErrorSignature, Scene
from truepose.effects.names import joint_of_subject
from truepose.effects.ports import Trait
from truepose.effects.registry import CAUSES, effects_with
from truepose.effects.signatures import signature_of
from truepose.identification.distributions import chi2_median
from truepose.identification.fit.robust import RobustFit
from truepose.identification.fit.solver import absorbed
from truepose.identification.verdict.judge import pure_error

NEST_LEVEL = 1e-3  # chance that nests which stand still are taken for contradicting
_SLOW = frozenset({"drift", "settling"})


def fixed_nests_contradict(fit: RobustFit, cell: ErrorSignature) -> bool:
    """Return whether fixed nests contradict a model and, with it, what it says of a cell.

    Parameters
    ----------
    fit : RobustFit
    cell : ErrorSignature
        Nests know nothing of what does not follow time.

    Returns
    -------
    bool
    """
    return cell.over == "time" and chance_of_nests(fit) < NEST_LEVEL


def chance_of_nests(fit: RobustFit) -> float:
    """Return the chance of readings like these where all fixed nests stand still.

    Parameters
    ----------
    fit : RobustFit

    Returns
    -------
    float
        Of the block that is least likely; 1 where no nest was read.
    """
    return min(block.contradiction(result) for block, result in zip(fit.blocks, fit.results, strict=True))


def instrument_suspects(selected: Selection, cell: ErrorSignature) -> tuple[Cause, ...]:
    """Return what of the instrument would look like a cell, as far as it was tried and not found.

    Parameters
    ----------
    selected : Selection
    cell : ErrorSignature

    Returns
    -------
    tuple of Cause
    """
    found = {Cause(pick.effect, pick.subject) for pick in selected.picks}
    tried = dict.fromkeys(
        Cause(candidate.effect, candidate.subject)
        for candidate in selected.pool.all
        if _alike(signature_of(candidate), cell)
    )
    return tuple(cause for cause in tried if cause not in found)


def _alike(other: ErrorSignature, cell: ErrorSignature) -> bool:
    """Whether a signature is of the instrument, over the same variable, in a shape like that of the cell."""
    same = other.shape == cell.shape or {other.shape, cell.shape} <= _SLOW
    return other.where == "tracker" and other.over == cell.over and same


Prepared = tuple[Family, Products]


@dataclass(frozen=True, slots=True)
class FamilyTest:
    """A family and how improbable its share of the residuals is by chance.

    Attributes
    ----------
    family : Family
    p_value : float
        Corrected for all families.
    products : Products
        Of its columns with the fit.
    """

    family: Family
    p_value: float
    products: Products


def prepared_families(fit: RobustFit, scene: Scene) -> tuple[Prepared, ...]:
    """Return every family with its whitened columns.

    Parameters
    ----------
    fit : RobustFit
    scene : Scene

    Returns
    -------
    tuple of (Family, Products)
        Those whose variable moves no reading are left out.
    """
    found = []
    for family in families(scene):
        terms = [terms_of(family, result.state) for result in fit.results]
        count = 1 + max((term.parameter for acting in terms for term in acting), default=-1)
        columns = term_columns(fit, terms, count)
        # A family that moves nothing would still count in the level that all families share.
        if float(np.abs(columns).max(initial=0.0)) > 0.0:
            found.append((family, products_of(fit, columns)))
    return tuple(found)


def score_families(prepared: tuple[Prepared, ...], past: Projection) -> tuple[FamilyTest, ...]:
    """Test every family past what is fitted.

    Parameters
    ----------
    prepared : tuple of (Family, Products)
    past : Projection

    Returns
    -------
    tuple of FamilyTest
        The most improbable first.
    """
    found = [
        FamilyTest(family, min(1.0, len(prepared) * _p_value(products, past)), products)
        for family, products in prepared
    ]
    return tuple(sorted(found, key=lambda one: one.p_value))


def _left(products: Products, past: Projection) -> tuple[FloatArray, FloatArray]:
    """Return products among columns (k, k) and with the residuals (k,), past what is fitted."""
    absorbed = past.absorbed(products)
    gram = products.columns @ products.columns.T - absorbed @ absorbed.T
    return np.asarray(gram), past.towards(products, absorbed)


def _p_value(products: Products, past: Projection) -> float:
    """Return the chance that noise alone lies as much along a family, not corrected for the others."""
    return chance(*_left(products, past), past.sums)


@dataclass(frozen=True, slots=True)
class RandomEffect:
    """A family as a random effect of its most likely size.

    Attributes
    ----------
    width : float
        Standard deviation of its parameters, 0 where none is seen.
    score : float
        Gain in BIC: twice the log likelihood, less what its one parameter (the width) costs.
    """

    width: float
    score: float


def as_random_effect(products: Products, past: Projection) -> RandomEffect:
    """Fit a family as a random effect (maximum likelihood, size of the noise profiled out).

    Parameters
    ----------
    products : Products
        Of its columns with the fit.
    past : Projection
        Past what is fitted.

    Returns
    -------
    RandomEffect
    """
    found = most_likely(*_left(products, past), past.sums)
    cost = float(np.log(max(past.sums.observations / past.sums.alike, 2.0)))
    return RandomEffect(found.width, found.gain - cost)


_STRUCTURE_LEVEL = 0.003  # chance that noise alone gives any dependence, over everything tried
_NOISE_BEYOND = 3.5  # standard deviations by which the typical residual exceeds what is stated
_AS_REPEATED = 0.01  # lack of fit beside pure error
_FEW_REVISITS = 5  # fewer say too little of the scatter to overrule what is stated
_AS_CALIBRATED = 1.5  # validation errors over the noise of the calibration that are no more than it
_MOST_TOLD = 4  # dependences; more are the same structure seen through variables that resemble each other


@dataclass(frozen=True, slots=True)
class Relation:
    """A dependence of what is left.

    Attributes
    ----------
    variable : str
        As reported, e.g. "angle of joint 4".
    p_value : float
        Corrected for everything that was tried in its kind.
    kind : str
        As of `Family`.
    joint : int or None
        0-based.
    family : Family or None
        None for single waves of a joint, for nests, and for what bad readings share.
    order : float
        Of a single wave, periods per turn; else 0.
    products : Products or None
        Of the family.
    """

    variable: str
    p_value: float
    kind: str
    joint: int | None
    family: Family | None
    order: float = 0.0
    products: Products | None = None


@dataclass(frozen=True, slots=True)
class Remainder:
    """What the extended model leaves.

    Attributes
    ----------
    depends : tuple of Relation
        The most improbable first.
    noise_scale : float
        Typical residual over the stated uncertainty [1].
    more_than_stated : bool
    explained_by_repeats : bool
        Revisits scatter as much.
    tails : Tails
    worse_unseen : float
        Validation errors over what explains them where far beyond it, else 0 [1].
    worse_at : WorstPoint or None
        A held-out point that is far worse than any was before.
    steps : AngleSteps or None
        Of the joint angles, where they are noise beyond what is stated.
    contradicted : bool
        Validation readings are predicted no better than by the initial model.
    withheld : Gain or None
        Of a description that does not predict validation readings better: it is in no model.
    """

    depends: tuple[Relation, ...]
    noise_scale: float
    more_than_stated: bool
    explained_by_repeats: bool
    tails: Tails
    worse_unseen: float = 0.0
    worse_at: WorstPoint | None = None
    steps: AngleSteps | None = None
    contradicted: bool = False
    withheld: Gain | None = None

    def also(self, more: Iterable[Relation]) -> "Remainder":
        """Return it with what it depends on as well; what is known of a variable already stays."""
        known = {one.variable for one in self.depends}
        new = [one for one in more if one.variable not in known]
        return replace(self, depends=_distinct([*self.depends, *new]))

    @property
    def structure(self) -> bool:
        """Whether something is left that is not noise."""
        # More noise than stated is no structure where revisits scatter as much, or the steps of the angles
        # explain it.
        lacking = self.more_than_stated and not self.explained_by_repeats and self.steps is None
        worse = self.clearly_worse_unseen or self.worse_at is not None or self.contradicted
        return bool(self.depends) or lacking or worse

    @property
    def clearly_worse_unseen(self) -> bool:
        """Whether validation errors are far beyond the noise, that of steps of the angles included."""
        expected = 0.0 if self.steps is None else _AS_CALIBRATED * self.noise_scale
        return self.worse_unseen > expected


def residual_dependence(
    start: Start,
    selected: Selection,
    families: tuple[Prepared, ...],
    without: tuple[str, ...],
    refuted: frozenset[Cause] = frozenset(),
) -> Remainder:
    """Test what is left against everything that it might depend on: the families, and single waves.

    Parameters
    ----------
    start : Start
    selected : Selection
        The extended model.
    families : tuple of (Family, Products)
        Prepared at its fit.
    without : tuple of str
        Causes that are left out of the library; their waves are still looked for.
    refuted : frozenset of Cause
        Single waves of a cause that was refuted on unseen points are chance and do not count again.

    Returns
    -------
    Remainder
        What validation readings say of it is added later.
    """
    fit, past = selected.fit, selected.pool.normal.past()
    found = [
        Relation(
            one.family.variable,
            one.p_value,
            one.family.kind,
            one.family.joint,
            one.family,
            products=one.products,
        )
        for one in score_families(families, past)
        if one.p_value <= _STRUCTURE_LEVEL
    ]
    found += _waves(start, selected, without, refuted)
    found += _nests(fit)
    scale, beyond = _noise(selected, len(past.scale))
    squared, components = _squared(selected)
    repeated = _repeats_scatter_as_much(selected)
    return Remainder(
        depends=_distinct(found)[:_MOST_TOLD],
        noise_scale=scale,
        more_than_stated=beyond,
        explained_by_repeats=repeated,
        # In units of the noise that the readings have. Noise twice as large as stated is no heavy tail.
        tails=tails(squared / max(scale, 1e-9) ** 2, components, fit.gross[0]),
        # Asked again of the extended model: what the start lacked may have outweighed them.
        steps=start.steps or (telling_steps(fit) if beyond and not repeated else None),
    )


def _nests(fit: RobustFit) -> list[Relation]:
    """Return what fixed nests say where they contradict the model: something moves in time."""
    chance = chance_of_nests(fit)
    variable = "time (frame of the instrument)"
    return [Relation(variable, chance, "time", None, None)] if chance < NEST_LEVEL else []


def _distinct(found: list[Relation]) -> tuple[Relation, ...]:
    """Return the most improbable dependence on each variable, the most improbable of all first."""
    kept: dict[str, Relation] = {}
    # A curve over an angle, its trend and its single waves are one dependence: it is reported once, by the
    # most significant of them.
    for one in sorted(found, key=lambda one: one.p_value):
        kept.setdefault(one.variable, one)
    return tuple(kept.values())


def _waves(
    start: Start, selected: Selection, without: tuple[str, ...], refuted: frozenset[Cause]
) -> list[Relation]:
    """Single waves of any order that are left: those that the selection did not try, or could not carry."""
    pool, waves = selected.pool, effects_with(Trait.WAVES)
    # Left out of the library they are in no pool, and a fast wave, which no smooth family holds, would pass
    # for noise.
    left_out = [name for name in waves if name in without]
    if left_out:
        pool = pool_candidates(
            selected.fit, [one for name in left_out for one in CAUSES[name].candidates(start.scene)]
        )
    if not pool.all:
        return []
    screened = screen(pool.view())
    # As for a pick: these are what the selection would have taken, had the readings carried them.
    beyond = (screened.p_value <= LEVEL) & (screened.score > 0.0)
    return [
        _wave(candidate, float(p_value))
        for candidate, left, p_value in zip(pool.all, beyond, screened.p_value, strict=True)
        if left and candidate.effect in waves and Cause(candidate.effect, candidate.subject) not in refuted
    ]


def _wave(candidate: Candidate, p_value: float) -> Relation:
    """Return a single wave as a dependence on its joint's angle."""
    joint = joint_of_subject(candidate.subject)
    return Relation(f"angle of {candidate.subject}", p_value, "angle", joint, None, candidate.variant)


def _squared(selected: Selection) -> tuple[FloatArray, int]:
    """Return the squared residual of each reading in its stated covariance, shape (n,), and d."""
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    stated = block.weighted(block.weights, 0.0)
    return stated.squared(result), result.residual.shape[1]


def _noise(selected: Selection, parameters: int) -> tuple[float, bool]:
    """Return the typical residual over the stated one, and whether that is beyond chance.

    With m the median of the squared whitened residuals of d components and f the freedom that the parameters
    leave, the ratio is m / (chi2 median(d) f); a sample median has the standard deviation 1 / (2 p sqrt(n)),
    p the density there. By the median it is blind to heavy tails. Of whitened residuals: what the readings of
    a stop share counts once, not once a reading.
    """
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    if block.stated_sigma() == 0.0:
        return 1.0, False
    readings, components = result.residual.shape
    white = block.weighted(block.weights, 0.0).whitened(result).reshape(readings, components)
    squared = (white**2).sum(axis=1)
    # With hardly more readings than parameters residuals are small whatever the noise is; a twentieth at
    # least.
    freedom = max(1.0 - parameters / max(selected.pool.normal.observations, 1.0), 0.05)
    expected = chi2_median(components)
    ratio = float(np.median(squared)) / (expected * freedom)
    spread = 0.5 / (float(np.exp(chi2_log_density(expected, components))) * expected * np.sqrt(readings))
    return float(np.sqrt(ratio)), bool(ratio > 1.0 + _NOISE_BEYOND * spread)


def _repeats_scatter_as_much(selected: Selection) -> bool:
    """Whether revisits scatter as much as the residuals: there is no lack of fit beside pure error."""
    fit, result = selected.fit, selected.fit.results[0]
    taken = absorbed(result.white_jacobian, fit.solution.covariance)
    pure = pure_error(fit.blocks[0], result.residual, taken)
    return pure is not None and pure.revisits >= _FEW_REVISITS and pure.p_value > _AS_REPEATED
