"""Two models of one robot, from measurements at two times: what of the robot itself has changed.

Base and tool are left out of the parameters: they say how the robot was set up for a measurement. What both
campaigns share makes the uncertainty of a difference too large, never too small. All differences of one
comparison share one level (S. Holm, Scand. J. Statist. 6, 1979, 65-70); whether anything changed at all is
one test of all of them together, d' (C1 + C2)^-1 d against chi-squared.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.definite import solved
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Readings
from truepose.domain.results.identification import Model, Parameter, Statistics, Unit
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification import judge, predict
from truepose.identification.distributions import chi2_exceeded
from truepose.identification.verdict.relative import aligned_errors, relative_errors
from truepose.judgement.multiplicity import holm

LEVEL: Final = 0.05  # of a false "changed" anywhere in one comparison
_FEWEST: Final = 4  # places that an alignment does not make equal by itself


@dataclass(frozen=True, slots=True)
class ParameterChange:
    """A parameter of the robot in both models, in its own unit."""

    name: str
    effect: str
    unit: Unit
    earlier: float
    later: float
    standard_uncertainty: float  # of the difference
    p_value: float | None  # corrected for all of the comparison; None: an uncertainty is not known
    significant: bool

    @property
    def difference(self) -> float:
        """Later less earlier."""
        return self.later - self.earlier


@dataclass(frozen=True, slots=True)
class Moved:
    """By how much the later model puts the tool elsewhere at n places, its base laid on the earlier one's."""

    places_mm: FloatArray  # (n, 3) by the later model, world
    moved_mm: FloatArray  # (n, 3) later less earlier
    mean_mm: float
    max_mm: float


@dataclass(frozen=True, slots=True)
class TwoModels:
    """What two models of one robot say of a change."""

    changes: tuple[ParameterChange, ...]
    gone: tuple[str, ...]  # parameters of the earlier model that the later one does not have
    new: tuple[str, ...]
    p_value: float | None  # that nothing changed; None: nothing can be compared
    moved: Moved | None  # None: too few places
    earlier_now: Statistics | None  # errors of the earlier model at the later readings, base laid on them
    later_now: Statistics | None


def compare_models(earlier: Model, later: Model, readings: Readings) -> TwoModels:
    """Say what changed on a robot between two models.

    Parameters
    ----------
    earlier, later : Model
        Of the same nominal robot.
    readings : Readings
        Those that judge the later model, or that it is made from.

    Raises
    ------
    ConfigurationError
        The models are of different nominal robots, or the readings do not fit one of them.
    """
    if earlier.robot.joints != later.robot.joints:
        raise ConfigurationError(
            f"{earlier.robot.name} and {later.robot.name} have different nominal tables; "
            "compare models of one robot."
        )
    before, after = _own(earlier), _own(later)
    common = [name for name in after if name in before]
    return TwoModels(
        changes=_changes([(before[name], after[name]) for name in common]),
        gone=tuple(name for name in before if name not in after),
        new=tuple(name for name in after if name not in before),
        p_value=_nothing_changed(earlier, later, common),
        moved=_moved(earlier, later, readings),
        earlier_now=_now(earlier, readings),
        later_now=_now(later, readings),
    )


def _own(model: Model) -> dict[str, Parameter]:
    set_up = effects_with(Trait.PLACING)
    return {one.name: one for one in model.parameters if one.effect not in set_up}


def _changes(pairs: Sequence[tuple[Parameter, Parameter]]) -> tuple[ParameterChange, ...]:
    uncertainties = [math.hypot(one.standard_uncertainty, other.standard_uncertainty) for one, other in pairs]
    p_values = holm([
        _p_value(other.value - one.value, u) for (one, other), u in zip(pairs, uncertainties, strict=True)
    ])
    return tuple(
        ParameterChange(
            other.name,
            other.effect,
            other.unit,
            one.value,
            other.value,
            u,
            p,
            p is not None and p < LEVEL,
        )
        for (one, other), u, p in zip(pairs, uncertainties, p_values, strict=True)
    )


def _p_value(difference: float, u: float) -> float | None:
    known = math.isfinite(difference) and math.isfinite(u) and u > 0.0
    return math.erfc(abs(difference) / u / math.sqrt(2.0)) if known else None


def _nothing_changed(earlier: Model, later: Model, names: Sequence[str]) -> float | None:
    """Return the chance of differences as large as these where nothing changed."""
    if not names:
        return None
    (before, first), (after, second) = (_of(model, names) for model in (earlier, later))
    covariance = first + second
    scale = np.sqrt(np.diag(covariance))
    if not (np.all(np.isfinite(scale)) and np.all(scale > 0.0)):
        return None
    scaled = (after - before) / scale
    squared = float(scaled @ solved(covariance / np.outer(scale, scale), scaled))
    return chi2_exceeded(squared, len(names))


def _of(model: Model, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return values (m,) and covariance (m, m) of parameters by their names."""
    all_names = [one.name for one in model.parameters]
    rows = [all_names.index(name) for name in names]
    return np.array([model.parameters[row].value for row in rows]), model.covariance[np.ix_(rows, rows)]


def _moved(earlier: Model, later: Model, readings: Readings) -> Moved | None:
    if len(readings) < _FEWEST:
        return None
    before, _ = predict(earlier, readings.stops, readings.nest)
    after, _ = predict(later, readings.stops, readings.nest)
    moved = aligned_errors(before, after)
    norms = np.linalg.norm(moved, axis=1)
    return Moved(after, moved, float(norms.mean()), float(norms.max()))


def _now(model: Model, readings: Readings) -> Statistics | None:
    found = relative_errors(judge(model, readings, model.repeatability_mm))
    return None if found is None else found.identified
