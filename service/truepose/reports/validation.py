"""A model held against readings that it never saw: the verdict, the report, and what it rests on."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Final, Literal

from rich.console import Group
from rich.text import Text as Line

from truepose.domain.campaign import Readings
from truepose.domain.identification import Model
from truepose.domain.validation import Decision, DistanceBin, ErrorsByPlace, Validation, ValidationUncertainty
from truepose.identification import judge
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Message, Text, message
from truepose.reports.cover_page import DECIDED, Front, OneFigure, applied_rule, error_bars, graded
from truepose.reports.error_tables import Row, error_table, pair_rows, title_of, turns_table
from truepose.reports.pose_test import pose_test_context, stated_conditions
from truepose.reports.report import Description, Report
from truepose.reports.rounding import millimetres, uncertainty, uncertainty_mm
from truepose.reports.tables import Table, on_terminal
from truepose.reports.traceability import NOT_STATED, ReportConditions, with_temperature
from truepose.reports.uncertainty_budget import scale_stated
from truepose.validation.iso9283.pose_test import PoseTest
from truepose.validation.outcome import outcome_of
from truepose.validation.uncertainty import DecidingReading, deciding_reading, known

_DECIDED: Final = {
    ("simple", "conforms"): "validation.simple.conforms",
    ("simple", "does not conform"): "validation.simple.does_not_conform",
    ("guard band", "conforms"): "validation.guard_band.conforms",
    ("guard band", "does not conform"): "validation.guard_band.does_not_conform",
    ("guard band", "cannot be decided"): "validation.guard_band.undecided",
}


def decision_sentence(validation: Validation) -> Message | None:
    """Return whether the limit is kept with the uncertainty counted; nothing without a limit."""
    decided = validation.decision
    if decided is None:
        return None
    return message(
        _DECIDED[decided.rule, decided.verdict],
        guard=millimetres(decided.guard_mm),
        error=millimetres(decided.error_mm),
    )


def verdict_sentence(validation: Validation) -> Message:
    """Return by which rule the limit was judged; without one, whether the model errs as it claims."""
    return decision_sentence(validation) or _claim_sentence(validation)


def _claim_sentence(validation: Validation) -> Message:
    """Return whether the model errs as it claims."""
    if validation.passed:
        return message("validation.as_claimed")
    if validation.position.identified.mean_mm > validation.position.nominal.mean_mm:
        return message("validation.not_below")
    if math.isnan(validation.claimed_mm):
        return message("validation.claims_unknown")
    return message("validation.far_above", claimed_mm=validation.claimed_mm)


@dataclass(frozen=True, slots=True)
class ValidationReport(Report):
    """A model held against readings, and what poses of ISO 9283 among them tell."""

    validation: Validation
    model: Model
    readings: Readings
    remarks: tuple[Text, ...] = ()
    pose_test: PoseTest | None = None

    def described(self, words: Catalogue) -> Description:
        """Return verdict, errors with their uncertainty, where they are, and the figures of ISO 9283.

        Raises
        ------
        ConfigurationError
            The readings are not those that the validation is of.
        """
        from truepose.reports.identification.observability import observability_context

        found, test, robot = self.validation, self.pose_test, self.model.robot.name
        shown = judge(self.model, self.readings, self.model.repeatability_mm)
        conditions = with_temperature(self.conditions, (self.readings.stops,))
        filled_in = {
            "validation": found,
            "verdict": verdict_sentence(found),
            "remarks": self.remarks,
            "errors": validation_table(found, words),
            "turns": turns_table(found, words),
            "pose_test": test,
            "conditions": conditions,
            "condition_rows": stated_conditions(test, conditions, words),
            "deciding": deciding_budget(shown, self.model, found.decision, conditions),
            **_figures(found, shown, words),
            **_places(found.places, words),
            **({} if test is None else pose_test_context(test, words)),
            **observability_context(self.model.parameters, (), words),
        }
        title = (
            words.say("pose_test.title", robot=robot) if test is not None and self.audit is not None else ""
        )
        front = validation_front(found, robot, words, title)
        return Description(front.title, robot, "validation.html", filled_in, front)


def validation_table(found: Validation, words: Catalogue) -> Table:
    """Return the errors of positions (or lengths), after the best alignment, and of distances."""
    u = found.uncertainty or ValidationUncertainty()
    absolute = "validation.positions" if found.quantity == "position" else "validation.lengths"
    blocks = (
        (absolute, found.position, u.position),
        ("validation.relative.aligned", found.relative, u.relative),
        ("validation.distances.all", found.distance, u.distance),
    )
    rows = (
        row
        for key, pair, known in blocks
        if pair is not None
        for row in pair_rows(words.say(key), pair, words, known)
    )
    return error_table(rows, words)


def _figures(found: Validation, shown: Assessment, words: Catalogue) -> dict[str, object]:
    """Return what is drawn of the errors, and what is seen there; the drawing library is slow to import."""
    from truepose.reports.captions import distances_sentence, figure_captions
    from truepose.reports.figures.curves import place_errors
    from truepose.reports.figures.histograms import distance_histogram, histogram

    errors, pairs = found.distance_errors, 0 if found.distance is None else found.distance.identified.n
    signed = None if errors is None else errors.identified
    return {
        "seen": figure_captions(shown),
        "histogram": histogram(shown, found.position.identified.noise_mm, words),
        "distances": None if errors is None else distance_histogram(errors, words),
        "distances_seen": signed and distances_sentence(signed.mean_mm, signed.positive_share, pairs),
        "pairs": pairs,
        "place_figure": found.places and place_errors(found.places, words),
    }


def _places(places: ErrorsByPlace | None, words: Catalogue) -> dict[str, object]:
    """Return where the errors are: over both distances, and by posture."""
    if places is None:
        return {"places": None}
    postures = [pair_rows(words.name(one.branch), one.errors, words) for one in places.branches]
    return {
        "places": places,
        "postures": error_table(chain.from_iterable(postures), words, "places.posture"),
        "from_zone": error_table(_shell_rows(places.from_zone, words), words, "places.distance"),
        "from_axis": error_table(_shell_rows(places.from_axis, words), words, "places.distance"),
    }


def _shell_rows(shells: Sequence[DistanceBin], words: Catalogue) -> Iterator[Row]:
    for shell in shells:
        label = words.say("places.shell", low_mm=shell.from_mm, high_mm=shell.to_mm)
        yield from pair_rows(label, shell.errors, words)


def validation_summary(validation: Validation, words: Catalogue = IN_ENGLISH) -> Group:
    """Return the errors and whether they pass, for a terminal."""
    tables = [on_terminal(validation_table(validation, words), words.say(title_of(validation)))]
    turns = turns_table(validation, words)
    if turns.rows:
        tables.append(on_terminal(turns, words.say("turns.title")))
    return Group(
        Line(words.spoken(outcome_of(validation))), *tables, Line(words.spoken(verdict_sentence(validation)))
    )


def validation_front(found: Validation, robot: str, words: Catalogue, title: str = "") -> Front:
    """Return whether the robot passes, against which limit and by which rule."""
    key, good = _validation_verdict(found)
    return Front(
        title=title or words.say("validation.title", robot=robot),
        look=graded(good),
        word=words.say(key),
        outcome=words.spoken(outcome_of(found)),
        sentence=words.spoken(verdict_sentence(found)),
        robot=robot,
        figure=_largest(found, words),
        picture=error_bars(found.position.nominal, found.position.identified, words, found.limit_mm),
        caption=words.say("front.bars" if found.limit_mm is None else "front.bars.limit"),
        rule=_rule(found, words),
    )


def _validation_verdict(found: Validation) -> tuple[str, bool | None]:
    if found.decision is not None:
        return DECIDED[found.decision.verdict]
    if found.limit_mm is None:
        return ("front.as_claimed", True) if found.passed else ("front.not_as_claimed", False)
    return ("front.passed", True) if found.passed else ("front.failed", False)


def _rule(found: Validation, words: Catalogue) -> str:
    return words.say("front.no_limit") if found.decision is None else applied_rule(found.decision, words)


def _largest(found: Validation, words: Catalogue) -> OneFigure:
    """Return the error that a limit is held against, with its expanded uncertainty."""
    figures, name = found.position.identified, words.say("front.largest")
    # The digits of the outcome above it, not those of its uncertainty: one figure is printed in one way.
    value = words.units.quantity(millimetres(figures.max_mm), "mm")
    known = None if found.uncertainty is None else found.uncertainty.position
    if known is None:
        return OneFigure(name, value, words.say("front.of", n=figures.n))
    expanded = uncertainty(2.0 * known.identified.max_mm)
    return OneFigure(name, value, words.say("front.of_with", u=expanded, n=figures.n))


@dataclass(frozen=True, slots=True)
class Part:
    """One row; None where nothing of it is counted."""

    source: Message
    kind: Literal["A", "B"]
    stated: Message
    u_mm: float | None = None
    share: float | None = None  # of the squared uncertainty, 0..1
    remark: Text = ""


@dataclass(frozen=True, slots=True)
class DecidingBudget:
    """The rows, and what they come to."""

    caption: Message
    parts: tuple[Part, ...]
    combined_mm: float
    guard_mm: float | None  # None: no limit was set, or its rule counts no uncertainty


def deciding_budget(
    judged: Assessment, model: Model, decision: Decision | None, conditions: ReportConditions
) -> DecidingBudget:
    """Return what makes u of the reading that decides; of the largest error where no limit was set."""
    error_mm = None if decision is None else decision.error_mm
    found = deciding_reading(judged, known(model, judged), error_mm)
    guard_mm = None if decision is None or decision.rule == "simple" else decision.guard_mm
    parts = (*_counted(found, model), *_left_out(conditions))
    return DecidingBudget(_caption(found, decision), parts, found.combined_u_mm, guard_mm)


def _caption(found: DecidingReading, decision: Decision | None) -> Message:
    if decision is None:
        key = "budget.deciding.largest"
    else:
        key = "budget.deciding.simple" if decision.rule == "simple" else "budget.deciding.guard"
    return message(key, config=found.config, error=millimetres(found.error_mm))


def _counted(found: DecidingReading, model: Model) -> Iterator[Part]:
    squared = found.combined_u_mm**2
    share = [u**2 / squared if squared > 0.0 else 0.0 for u in (found.reading_u_mm, found.placement_u_mm)]
    stated = message("budget.deciding.u", u=uncertainty_mm(found.reading_u_mm))
    remark = message("budget.deciding.reading.remark")
    yield Part(message("budget.deciding.reading"), "B", stated, found.reading_u_mm, share[0], remark)
    yield Part(
        message("budget.deciding.placement"),
        "A",
        message("budget.parameters.stated", parameters=len(model.parameters)),
        found.placement_u_mm,
        share[1],
        message("budget.deciding.placement.remark"),
    )


def _left_out(conditions: ReportConditions) -> Iterator[Part]:
    """Yield what is not counted: what is judged, and what nobody verified."""
    judged = message("budget.deciding.judged")
    yield Part(message("budget.scatter"), "B", judged, remark=message("budget.deciding.judged.remark"))
    yield Part(
        message("budget.scale"), "B", scale_stated(conditions), remark=message("budget.scale.not_included")
    )
    warmth = conditions.temperature_c
    stated = (
        message(NOT_STATED)
        if warmth is None
        else message("conditions.temperatures", lowest_c=warmth[0], highest_c=warmth[1])
    )
    yield Part(message("budget.temperature"), "B", stated, remark=message("budget.temperature.not_included"))
