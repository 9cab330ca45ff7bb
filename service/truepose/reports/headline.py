"""The one sentence that a person at the robot reads, and the few numbers beside it."""

import math
from dataclasses import dataclass

from truepose.domain.results import Identification, NominalAndIdentified, Statistics, Status
from truepose.identification.verdict.judge import Judged
from truepose.reports.rounding import millimetres, rounded, uncertainty
from truepose.reports.uncertainty.budget import Budget
from truepose.reports.uncertainty.judged import judging_figures
from truepose.words.catalogue import english


@dataclass(frozen=True, slots=True)
class Figure:
    """A number of the first screen."""

    name: str
    value: str
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Headline:
    """What stands above everything else."""

    sentence: str
    good: bool
    figures: tuple[Figure, ...] = ()


def headline(identification: Identification, judged: Judged | None, budget: Budget | None) -> Headline:
    """Return the headline; whatever was not reached is said first."""
    pair = judging_figures(identification)
    if judged is None or budget is None or pair is None:
        return Headline(english(identification.message) or "No model was identified.", good=False)
    converged = identification.status is Status.CONVERGED
    warning = "" if converged else f"Not to be used: {english(identification.message)} "
    return Headline(
        sentence=warning + _sentence(identification, budget, pair),
        good=converged and _improves(pair),
        figures=_figures(identification, budget, pair),
    )


def _improves(pair: NominalAndIdentified) -> bool:
    nominal, identified = pair.nominal, pair.identified
    return identified.mean_mm < nominal.mean_mm and identified.rms_mm < nominal.rms_mm


def _sentence(identification: Identification, budget: Budget, pair: NominalAndIdentified) -> str:
    nominal, identified = pair.nominal, pair.identified
    verb = "falls from" if identified.mean_mm < nominal.mean_mm else "does not fall: it goes from"
    before, after = _stated(nominal, budget.before_mm), _stated(identified, budget.after_mm)
    return (
        f"On {judged_on(identification, nominal)} the mean {identification.quantity} error {verb} {before} "
        f"with the nominal model to {after} with the identified one; {_noise(identified)}"
        f"{_far_errors(pair)}"
    )


def _stated(statistics: Statistics, u_mm: float) -> str:
    return f"{rounded(statistics.mean_mm, 2 * u_mm)} mm ({_expanded(u_mm)})"


def _expanded(u_mm: float) -> str:
    if not math.isfinite(u_mm):
        return "U not known from one configuration"
    return f"U = {uncertainty(2 * u_mm)} mm"


def _far_errors(pair: NominalAndIdentified) -> str:
    """Say when a falling mean hides growing errors: the mean alone would praise such a model."""
    nominal, identified = pair.nominal, pair.identified
    if identified.rms_mm < nominal.rms_mm or identified.mean_mm >= nominal.mean_mm:
        return ""
    change = f"{millimetres(nominal.rms_mm)} mm before, {millimetres(identified.rms_mm)} mm after"
    return f" But the RMS does not fall ({change}): some errors have grown."


def _noise(identified: Statistics) -> str:
    if identified.noise_mm == 0.0:
        return "the noise of instrument and robot is not stated."
    if identified.noise_mm >= identified.mean_mm:
        return (
            f"the noise of instrument and robot alone would show {millimetres(identified.noise_mm)} mm, "
            "so the model's own error is below what these readings can tell."
        )
    return (
        f"of this, the noise of instrument and robot alone would show {millimetres(identified.noise_mm)} mm."
    )


def judged_on(identification: Identification, statistics: Statistics) -> str:
    """Return what the figures stand on, e.g. "1,000 held-out positions"."""
    things = identification.quantity if statistics.n == 1 else f"{identification.quantity}s"
    if identification.validation is not None:
        return f"{statistics.n:,} held-out {things}"
    if identification.cross_validation is not None:
        return f"{statistics.n:,} {things}, each predicted by a model that never saw its configuration,"
    return f"{statistics.n:,} {things} that the model was made from"


def _figures(
    identification: Identification, budget: Budget, pair: NominalAndIdentified
) -> tuple[Figure, ...]:
    factor = pair.nominal.mean_mm / pair.identified.mean_mm if pair.identified.mean_mm > 0.0 else float("inf")
    return (
        _mean("Mean error before", pair.nominal, budget.before_mm),
        _mean("Mean error after", pair.identified, budget.after_mm),
        Figure(
            "Largest error after",
            f"{millimetres(pair.identified.max_mm)} mm",
            f"before {millimetres(pair.nominal.max_mm)} mm",
        ),
        Figure("Noise alone", f"{millimetres(pair.identified.noise_mm)} mm", _noise_of(identification, pair)),
        Figure("Improvement", f"{factor:.3g} times", "mean error before over after, noise included"),
    )


def _noise_of(identification: Identification, pair: NominalAndIdentified) -> str:
    """Return of which readings the noise is, and what is in it."""
    if pair.identified.noise_mm == 0.0:
        return "not stated"
    readings = f"{pair.identified.n:,} {'held-out' if identification.validation else 'calibration'} readings"
    return f"mean that instrument and robot scatter would show on these {readings}"


def _mean(name: str, statistics: Statistics, u_mm: float) -> Figure:
    return Figure(name, f"{rounded(statistics.mean_mm, 2 * u_mm)} mm", _expanded(u_mm))
