"""The uncertainty budget of a decision about a limit: what is counted, what is judged, what is left out."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from truepose.domain.results.identification import Model
from truepose.domain.results.validation import Decision
from truepose.domain.sentences import Sentence, Text, said
from truepose.identification.verdict.judge import Judged
from truepose.judgement.deciding import DecidingReading, deciding_reading
from truepose.judgement.uncertainty import known
from truepose.reports.traceability.conditions import NOT_STATED, ReportConditions
from truepose.reports.wording.rounding import millimetres, uncertainty, uncertainty_mm


@dataclass(frozen=True, slots=True)
class Part:
    """One row; None where nothing of it is counted."""

    source: Sentence
    kind: Literal["A", "B"]
    stated: Sentence
    u_mm: float | None = None
    share: float | None = None  # of the squared uncertainty, 0..1
    remark: Text = ""


@dataclass(frozen=True, slots=True)
class DecidingBudget:
    """The rows, and what they come to."""

    caption: Sentence
    parts: tuple[Part, ...]
    combined_mm: float
    guard_mm: float | None  # None: no limit was set, or its rule counts no uncertainty


def deciding_budget(
    judged: Judged, model: Model, decision: Decision | None, conditions: ReportConditions
) -> DecidingBudget:
    """Return what makes u of the reading that decides; of the largest error where no limit was set."""
    error_mm = None if decision is None else decision.error_mm
    found = deciding_reading(judged, known(model, judged), error_mm)
    guard_mm = None if decision is None or decision.rule == "simple" else decision.guard_mm
    parts = (*_counted(found, model), *_left_out(conditions))
    return DecidingBudget(_caption(found, decision), parts, found.combined_u_mm, guard_mm)


def _caption(found: DecidingReading, decision: Decision | None) -> Sentence:
    if decision is None:
        key = "budget.deciding.largest"
    else:
        key = "budget.deciding.simple" if decision.rule == "simple" else "budget.deciding.guard"
    return said(key, config=found.config, error=millimetres(found.error_mm))


def _counted(found: DecidingReading, model: Model) -> Iterator[Part]:
    squared = found.combined_u_mm**2
    share = [u**2 / squared if squared > 0.0 else 0.0 for u in (found.reading_u_mm, found.placement_u_mm)]
    stated = said("budget.deciding.u", u=uncertainty_mm(found.reading_u_mm))
    remark = said("budget.deciding.reading.remark")
    yield Part(said("budget.deciding.reading"), "B", stated, found.reading_u_mm, share[0], remark)
    yield Part(
        said("budget.deciding.placement"),
        "A",
        said("budget.parameters.stated", parameters=len(model.parameters)),
        found.placement_u_mm,
        share[1],
        said("budget.deciding.placement.remark"),
    )


def _left_out(conditions: ReportConditions) -> Iterator[Part]:
    """Yield what is not counted: what is judged, and what nobody verified."""
    judged = said("budget.deciding.judged")
    yield Part(said("budget.scatter"), "B", judged, remark=said("budget.deciding.judged.remark"))
    yield Part(said("budget.scale"), "B", _scale(conditions), remark=said("budget.scale.not_included"))
    warmth = conditions.temperature_c
    stated = (
        said(NOT_STATED)
        if warmth is None
        else said("conditions.temperatures", lowest_c=warmth[0], highest_c=warmth[1])
    )
    yield Part(said("budget.temperature"), "B", stated, remark=said("budget.temperature.not_included"))


def _scale(conditions: ReportConditions) -> Sentence:
    relative = conditions.scale_standard_uncertainty
    if relative is None:
        return said("budget.scale.not_verified")
    return said("budget.scale.stated", u=uncertainty(relative))
