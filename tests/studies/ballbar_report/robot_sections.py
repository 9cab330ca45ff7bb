"""The comparison of ballbar, tracker and the thesis' procedure as tables."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from tests.studies.ballbar_report.plans import KINDS, PlanKind
from tests.studies.ballbar_report.ratios import ratio_of, ratio_row
from tests.studies.ballbar_report.robots import Outcome, Stated, TrueError
from tests.studies.report_command import informing, target_row
from truepose.reports.table_report import Row, Section

TILTED: Final = "lrmate-tilted"
EVERYDAY: Final = "lrmate-everyday"
SCENARIOS: Final = (TILTED, EVERYDAY)
_OVER_TRACKER: Final = {
    (TILTED, "one"): 0.60,
    (TILTED, "fourth-cup"): 0.60,
    (TILTED, "four"): 0.55,
    (EVERYDAY, "one"): 1.30,
    (EVERYDAY, "fourth-cup"): 1.15,
    (EVERYDAY, "four"): 1.15,
}
_OVER_THESIS: Final = {TILTED: 0.35, EVERYDAY: 0.80}
_HALF_WIDTH_95: Final = 1.96

Judged = Callable[[Outcome], TrueError | None]


def robot_sections(outcomes: Sequence[Outcome]) -> tuple[Section, ...]:
    """Return a section for every scenario."""
    present = [scenario for scenario in SCENARIOS if any(one.scenario == scenario for one in outcomes)]
    return tuple(
        _section(scenario, [one for one in outcomes if one.scenario == scenario]) for scenario in present
    )


def _section(scenario: str, outcomes: Sequence[Outcome]) -> Section:
    rows: list[Row] = []
    for kind in KINDS:
        own = [one for one in outcomes if one.kind == kind.key]
        if own:
            rows += _rows(scenario, kind, own)
    faults = [f"{one.kind}, seed {one.seed}: {one.fault}" for one in outcomes if one.fault]
    broken = target_row(
        "sessions that gave no figures", "0", "; ".join([str(len(faults)), *faults[:3]]), not faults
    )
    note = (
        "Mean distances to where the nests truly were, at the tracker's validation positions; a ballbar's "
        "model is tied to the world by the true places of its cups. Ratios: mean over robots ± its standard "
        "error."
    )
    return Section(scenario, (*rows, broken), note)


def _rows(scenario: str, kind: PlanKind, outcomes: Sequence[Outcome]) -> list[Row]:
    def over(first: Judged, second: Judged, figure: str, limit: float | None = None) -> list[Row]:
        pairs = [(a, b) for one in outcomes if (a := first(one)) and (b := second(one))]
        tied = ratio_of([(a.tied_mm, b.tied_mm) for a, b in pairs])
        aligned = ratio_of([(a.aligned_mm, b.aligned_mm) for a, b in pairs])
        name = f"{kind.label}: ballbar over {figure}"
        return [ratio_row(name, tied, limit), ratio_row(f"{name}, aligned", aligned)]

    poses = sorted({one.poses for one in outcomes})
    return [
        *over(_ballbar, _tracker, "tracker", _OVER_TRACKER[scenario, kind.key]),
        *over(_ballbar, lambda one: one.thesis, "thesis", _OVER_THESIS[scenario]),
        *over(_ballbar, lambda one: one.thesis_same_model, "thesis with the same model"),
        informing(f"{kind.label}: without the thesis' procedure", _without_thesis(outcomes)),
        informing(f"{kind.label}: mean errors", _means(outcomes)),
        informing(
            f"{kind.label}: poses; legs out of range",
            f"{_span(poses)}; {sum(o.out_of_range for o in outcomes)}",
        ),
    ]


def _ballbar(outcome: Outcome) -> TrueError | None:
    return outcome.ballbar


def _tracker(outcome: Outcome) -> TrueError | None:
    return outcome.tracker


def _without_thesis(outcomes: Sequence[Outcome]) -> str:
    without = sum(bool(one.no_thesis) for one in outcomes)
    lost = sum(one.lost for one in outcomes)
    return f"{without} of {len(outcomes)} robots; {lost} poses of the others lost"


def _means(outcomes: Sequence[Outcome]) -> str:
    def mean(judged: Judged) -> str:
        errors = [error.tied_mm for one in outcomes if (error := judged(one))]
        return f"{np.mean(errors):.4f}" if errors else "-"

    thesis = mean(lambda one: one.thesis)
    return f"ballbar {mean(_ballbar)}, tracker {mean(_tracker)}, thesis {thesis} mm"


def _span(numbers: Sequence[int]) -> str:
    return str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]}"


def stated_section(outcomes: Sequence[Outcome]) -> Section:
    """Return how well what models state of themselves agrees with the truth."""
    rows: list[Row] = []
    for kind in KINDS:
        stated = [one.stated for one in outcomes if one.kind == kind.key and one.stated is not None]
        if stated:
            rows += _stated_rows(kind, stated)
    note = "True parameters: the same session identified from exact lengths between true cups and true nests."
    return Section(f"{TILTED}: stated uncertainties", tuple(rows), note)


def _stated_rows(kind: PlanKind, stated: Sequence[Stated]) -> list[Row]:
    scores = np.abs(np.concatenate([one.scores for one in stated]))
    errors = np.array([(one.tied_mm, one.world_mm, one.uncertainty_mm) for one in stated])
    tied, world, said = np.sqrt(np.mean(errors**2, axis=0))
    inside = 100.0 * np.mean(scores <= _HALF_WIDTH_95)
    rms = np.sqrt(np.mean(scores**2))
    return [
        informing(
            f"{kind.label}: parameters off, in stated uncertainties",
            f"RMS {rms:.2f}; {inside:.1f} % within 1.96 ({len(scores)} parameters of {len(stated)} robots)",
        ),
        informing(
            f"{kind.label}: predicted positions, RMS per axis",
            f"stated {said:.4f}, off {tied:.4f} tied to the cups, {world:.3f} mm in the world",
        ),
    ]
