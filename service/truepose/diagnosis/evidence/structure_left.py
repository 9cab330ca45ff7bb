"""What is left after the extended model: structure and what it depends on, or noise and of which kind."""

from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.distributions import chi2_log_density
from truepose.diagnosis.evidence.remaining import Prepared, structured
from truepose.diagnosis.evidence.witnesses import LEVEL as LEVEL_OF_NESTS
from truepose.diagnosis.evidence.witnesses import chance_of_nests
from truepose.diagnosis.readings.angle_steps import AngleSteps, telling_steps
from truepose.diagnosis.readings.single_readings import Tails, tails
from truepose.diagnosis.screening.candidates import pooled
from truepose.diagnosis.screening.explained import screen
from truepose.diagnosis.screening.normal_equations import Products
from truepose.diagnosis.screening.selection import LEVEL, Selected
from truepose.diagnosis.screening.smooth_families import Family
from truepose.diagnosis.start import Start
from truepose.domain.arrays import FloatArray
from truepose.domain.results.causes import Cause
from truepose.domain.results.diagnosis import Gain, WorstPoint
from truepose.effects.causes import Candidate
from truepose.effects.joints.joint_harmonics import NAME as HARMONICS
from truepose.effects.names import joint_of_subject
from truepose.effects.registry import CAUSES
from truepose.identification.distributions import chi2_median
from truepose.identification.fit.robust import RobustFit
from truepose.identification.verdict.pure_error import pure_error

_STRUCTURE_LEVEL = 0.003  # chance that noise alone gives any dependence, over everything tried
_NOISE_BEYOND = 3.5  # standard deviations by which the typical residual exceeds what is stated
_AS_REPEATED = 0.01  # lack of fit beside pure error
_FEW_REVISITS = 5  # fewer say too little of the scatter to overrule what is stated
_AS_CALIBRATED = 1.5  # validation errors over the noise of the calibration that are no more than it
_MOST_TOLD = 4  # dependences; more are the same structure seen through variables that resemble each other


@dataclass(frozen=True, slots=True)
class Depends:
    """A dependence of what is left."""

    variable: str
    p_value: float
    kind: str
    joint: int | None
    family: Family | None  # None for single waves of a joint
    order: float = 0.0
    products: Products | None = None  # of the family


@dataclass(frozen=True, slots=True)
class Left:
    """What the extended model leaves."""

    depends: tuple[Depends, ...]
    noise_scale: float  # typical residual over the stated uncertainty
    more_than_stated: bool
    explained_by_repeats: bool  # revisits scatter as much
    tails: Tails
    worse_unseen: float = 0.0  # validation errors over what explains them where far beyond it, else 0
    worse_at: WorstPoint | None = None  # a held-out point that is far worse than any was before
    steps: AngleSteps | None = None  # of the joint angles, where they are noise beyond what is stated
    contradicted: bool = False  # validation readings are foretold no better than by the start model
    withheld: Gain | None = None  # of a description that foretells them no better: it is in no model

    @property
    def structure(self) -> bool:
        """Whether something is left that is not noise."""
        lacking = self.more_than_stated and not self.explained_by_repeats and self.steps is None
        worse = self.clearly_worse_unseen or self.worse_at is not None or self.contradicted
        return bool(self.depends) or lacking or worse

    @property
    def clearly_worse_unseen(self) -> bool:
        """Whether validation errors are far beyond the noise, that of steps of the angles included."""
        expected = 0.0 if self.steps is None else _AS_CALIBRATED * self.noise_scale
        return self.worse_unseen > expected


def left_by(
    start: Start,
    selected: Selected,
    families: tuple[Prepared, ...],
    without: tuple[str, ...],
    refuted: frozenset[Cause] = frozenset(),
) -> Left:
    """Test what is left against everything that it might depend on: the families, and single waves.

    Single waves of a cause that was refuted on unseen points are chance and do not count again.
    """
    fit, past = selected.fit, selected.pool.normal.past()
    found = [
        Depends(
            one.family.variable,
            one.p_value,
            one.family.kind,
            one.family.joint,
            one.family,
            products=one.products,
        )
        for one in structured(families, past)
        if one.p_value <= _STRUCTURE_LEVEL
    ]
    found += _waves(start, selected, without, refuted)
    found += _nests(fit)
    found.sort(key=lambda one: one.p_value)
    scale, beyond = _noise(selected, len(past.scale))
    squared, components = _squared(selected)
    repeated = _repeats_scatter_as_much(selected)
    return Left(
        depends=_distinct(found)[:_MOST_TOLD],
        noise_scale=scale,
        more_than_stated=beyond,
        explained_by_repeats=repeated,
        tails=tails(squared / max(scale, 1e-9) ** 2, components, fit.gross[0]),
        steps=start.steps or (telling_steps(fit) if beyond and not repeated else None),
    )


def _nests(fit: RobustFit) -> list[Depends]:
    """Return what fixed nests say where they contradict the model: something moves in time."""
    chance = chance_of_nests(fit)
    variable = "time (frame of the instrument)"
    return [Depends(variable, chance, "time", None, None)] if chance < LEVEL_OF_NESTS else []


def _distinct(found: list[Depends]) -> tuple[Depends, ...]:
    kept: dict[str, Depends] = {}
    for one in found:
        kept.setdefault(one.variable, one)
    return tuple(kept.values())


def _waves(
    start: Start, selected: Selected, without: tuple[str, ...], refuted: frozenset[Cause]
) -> list[Depends]:
    """Single waves of any order that are left: those that the selection did not try, or could not carry."""
    if HARMONICS in without:
        pool = pooled(selected.fit, CAUSES[HARMONICS].candidates(start.scene))
    else:
        pool = selected.pool
    if not pool.all:
        return []
    screened = screen(pool.view())
    beyond = (screened.p_value <= LEVEL) & (screened.score > 0.0)
    return [
        _wave(candidate, float(p_value))
        for candidate, left, p_value in zip(pool.all, beyond, screened.p_value, strict=True)
        if left and candidate.effect == HARMONICS and Cause(HARMONICS, candidate.subject) not in refuted
    ]


def _wave(candidate: Candidate, p_value: float) -> Depends:
    joint = joint_of_subject(candidate.subject)
    return Depends(f"angle of {candidate.subject}", p_value, "angle", joint, None, candidate.variant)


def _squared(selected: Selected) -> tuple[FloatArray, int]:
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    stated = block.weighted(block.weights, 0.0)
    return stated.squared(result), result.residual.shape[1]


def _noise(selected: Selected, parameters: int) -> tuple[float, bool]:
    """Typical residual over the stated one, by the median: blind to heavy tails.

    Of whitened residuals: what the readings of a stop share counts once, not once a reading.
    """
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    if block.stated_sigma() == 0.0:
        return 1.0, False
    readings, components = result.residual.shape
    white = block.weighted(block.weights, 0.0).whitened(result).reshape(readings, components)
    squared = (white**2).sum(axis=1)
    freedom = max(1.0 - parameters / max(selected.pool.normal.observations, 1.0), 0.05)
    expected = chi2_median(components)
    ratio = float(np.median(squared)) / (expected * freedom)
    spread = 0.5 / (float(np.exp(chi2_log_density(expected, components))) * expected * np.sqrt(readings))
    return float(np.sqrt(ratio)), bool(ratio > 1.0 + _NOISE_BEYOND * spread)


def _repeats_scatter_as_much(selected: Selected) -> bool:
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    pure = pure_error(block, result.residual, len(selected.fit.structure.specs))
    return pure is not None and pure.revisits >= _FEW_REVISITS and pure.p_value > _AS_REPEATED
