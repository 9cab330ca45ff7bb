"""The report of a diagnosis: what the model gets wrong, why, and how anyone can check it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from markupsafe import Markup

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause, Confidence, Dependence, Diagnosis, Finding, NextMeasurement
from truepose.domain.identification import Model, Statistics
from truepose.domain.set_aside import listed
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text
from truepose.reports.captions import (
    curve_sentence,
    errors_sentence,
    gains_sentence,
    map_sentence,
    places_sentence,
)
from truepose.reports.cause_words import cause_words, causes_listed, verdict_words
from truepose.reports.cover_page import Front, OneFigure, error_bars
from truepose.reports.diagnosis.cause_map import MapEntry, cause_map, map_picture, share_text
from truepose.reports.diagnosis.findings import finding_blocks
from truepose.reports.diagnosis.rows import described_rows, described_sentence, ruled_out_table
from truepose.reports.error_tables import error_table, figures_row
from truepose.reports.figures.error_maps import error_maps
from truepose.reports.figures.histograms import comparison
from truepose.reports.figures.residuals import CurveFigure, residual_curve
from truepose.reports.figures.svg_rendering import (
    AFTER,
    INK,
    label,
    mark_axis,
    new_figure,
    page_style,
    to_svg,
)
from truepose.reports.identification.parameters import parameter_cells, parameter_table
from truepose.reports.pages import capitalise
from truepose.reports.report import Description, Report
from truepose.reports.rounding import MISSING, format_fixed, millimetres, with_minus
from truepose.reports.tables import Remarked, Table, heads_of
from truepose.reports.traceability import ReportConditions, condition_rows
from truepose.validation.outcome import outcome_of

_HELD_OUT = {
    ("validation", "position"): "report.held_out.positions",
    ("validation", "length"): "report.held_out.lengths",
    ("cross_validation", "position"): "report.cross_validated.positions",
    ("cross_validation", "length"): "report.cross_validated.lengths",
}
_CAMPAIGN = "campaign"  # where a model tells what its readings are called
_NAMED_ABOVE = frozenset({_CAMPAIGN, "robot"})  # rows of the origin that every diagnosis has


@dataclass(frozen=True, slots=True)
class DiagnosisReport(Report):
    """A diagnosis, whatever its verdict."""

    diagnosis: Diagnosis
    campaign: str = ""  # what the readings are called; "" is printed as not stated

    def described(self, words: Catalogue) -> Description:
        """Return verdict, map, findings, errors, what is left or ruled out, and what to measure next."""
        diagnosis, blocks = self.diagnosis, finding_blocks(self.diagnosis, words)
        counted = len(diagnosis.findings)
        tried = [one for one in diagnosis.ruled_out if one.visible]
        unseen = [one for one in diagnosis.ruled_out if not one.visible]
        filled_in = {
            "diagnosis": diagnosis,
            "campaign": self.campaign or _named_campaign(diagnosis.model),
            "stated_conditions": tuple(_stated(self.conditions, words)),
            "verdict": verdict_words(diagnosis.verdict, answered=diagnosis.model is not None, words=words),
            "set_aside": listed(diagnosis.set_aside),
            "origin": () if diagnosis.model is None else tuple(_origin(diagnosis.model, words)),
            "findings": blocks[:counted],
            "small": blocks[counted:],
            "counted": _counted(diagnosis, words),
            "held_out": _held_out(diagnosis, words),
            **_map(diagnosis, words),
            "before_after": errors_table(diagnosis, words),
            "gains": gains(diagnosis.all_findings, words),
            "gains_seen": gains_sentence(diagnosis.all_findings, words),
            "dependences": _dependences(diagnosis, words),
            "described": described_rows(diagnosis.remaining.described, words),
            "added_words": added_words(diagnosis, words),
            "described_sentence": described_sentence(diagnosis.remaining, words),
            "found": ruled_out_table(tried, words, tried=True),
            "unseen": ruled_out_table(unseen, words, tried=False),
            "proposals": tuple(_proposal(one, words) for one in diagnosis.next_measurements),
            "added": added_table(diagnosis, words),
            **_errors(diagnosis, words),
        }
        front = diagnosis_front(diagnosis, words)
        return Description(front.title, front.robot, "diagnosis.html", filled_in, front)


def diagnosis_front(diagnosis: Diagnosis, words: Catalogue) -> Front:
    """Return what the model gets wrong, and what knowing it brings."""
    answered = diagnosis.model is not None
    verdict = verdict_words(diagnosis.verdict, answered=answered, words=words)
    front = Front(
        title=words.say("report.title", robot=diagnosis.robot),
        look=verdict.look,
        word=verdict.word,
        outcome=words.spoken(outcome_of(diagnosis)),
        sentence=words.spoken(diagnosis.message),
        robot=diagnosis.robot,
        rule=verdict.meaning,
    )
    before, after = diagnosis.before, diagnosis.after
    if before is None or after is None:
        return front
    return replace(
        front,
        figure=_left(diagnosis, after, words),
        picture=_bars(diagnosis.nominal, before, after, words),
        caption=words.say("front.bars.diagnosis" if diagnosis.nominal is None else "front.bars"),
    )


def _bars(nominal: Statistics | None, before: Statistics, after: Statistics, words: Catalogue) -> Markup:
    """Draw what the outcome says; the initial model keeps its name where nothing nominal was recorded."""
    if nominal is None:
        return error_bars(before, after, words, names=("before", "after"))
    return error_bars(nominal, after, words)


def _left(diagnosis: Diagnosis, after: Statistics, words: Catalogue) -> OneFigure:
    value = words.units.quantity(millimetres(after.mean_mm), "mm")
    return OneFigure(words.say("headline.mean_after"), value, _held_out(diagnosis, words))


@dataclass(frozen=True, slots=True)
class DependenceBlock:
    """Something that what is left depends on, with its picture."""

    dependence: Dependence
    name: str
    curve: CurveFigure | None
    seen: Text = ""  # what the curve shows


@dataclass(frozen=True, slots=True)
class Proposal:
    """An action or configurations to measure next, as text."""

    sentence: str
    separates: str
    configurations: tuple[tuple[str, ...], ...]  # deg


def _counted(diagnosis: Diagnosis, words: Catalogue) -> str:
    certain = sum(finding.confidence is Confidence.CERTAIN for finding in diagnosis.findings)
    likely = len(diagnosis.findings) - certain
    if not diagnosis.small:
        return words.say("report.counted", certain=certain, likely=likely)
    return words.say("report.counted.small", certain=certain, likely=likely, small=len(diagnosis.small))


def _held_out(diagnosis: Diagnosis, words: Catalogue) -> str:
    if diagnosis.after is None:
        return ""
    return words.say(_HELD_OUT[diagnosis.held_out, diagnosis.quantity], number=diagnosis.after.n)


def errors_table(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Table | None:
    """Return the held-out errors of each model, nominal first; None where nothing could be fitted."""
    if diagnosis.before is None or diagnosis.after is None:
        return None
    started = words.between.join(map(words.effect, diagnosis.start_effects))
    before = Remarked(words.say("report.start_model"), started)
    after = Remarked(words.say("after"), added_words(diagnosis, words) or words.say("added.same_model"))
    rows = [figures_row(before, "", diagnosis.before), figures_row(after, "", diagnosis.after)]
    if diagnosis.nominal is not None:
        rows.insert(0, figures_row(words.say("model.nominal"), "", diagnosis.nominal))
    return error_table(rows, words, "report.model").of_columns(0, *range(2, 8))


def added_words(diagnosis: Diagnosis, words: Catalogue) -> str:
    """Return what the extended model has beyond the start, "" where there is nothing."""
    if diagnosis.findings:
        return words.say("added.both" if diagnosis.remaining.described else "added.findings")
    return words.say("added.described") if diagnosis.remaining.described else ""


def _map(diagnosis: Diagnosis, words: Catalogue) -> dict[str, object]:
    found = cause_map(diagnosis)
    if found is None:
        return {"map": None}
    heads = heads_of(words, "map.where", "map.over", "map.told", "map.share")
    return {
        "map": map_picture(found, words),
        "map_table": Table(heads, [_map_row(cell, words) for cell in found.cells], names=3),
        "map_rivals": bool(found.links),
        "map_seen": map_sentence(found),
    }


def _map_row(cell: MapEntry, words: Catalogue) -> tuple[str, str, str, str]:
    """Return a cell as where, over what, what is told there, and its share."""
    findings = [words.say("map.row.finding", number=number) for number in cell.findings]
    rivals = [words.say("map.row.rival", number=number) for number in cell.rival_of]
    told = words.between.join([*findings, *rivals] or [words.say("map.described")])
    where = capitalise(words.name(cell.where))
    return where, words.name(cell.over), told, share_text(cell.share) or MISSING


def _origin(model: Model, words: Catalogue) -> Iterator[tuple[str, str | int]]:
    """Yield what the model says of its readings beside their name, in words."""
    told = model.identified_from.items()
    return (
        (
            words.name(name.replace("_", " ")),
            words.units.formatted(said, ".3f", "") if isinstance(said, float) else said,
        )
        for name, said in told
        if name not in _NAMED_ABOVE
    )


def _named_campaign(model: Model | None) -> str:
    return "" if model is None else str(model.identified_from.get(_CAMPAIGN, ""))


def _stated(conditions: ReportConditions, words: Catalogue) -> Iterator[tuple[str, str]]:
    """Yield what somebody stated: a diagnosis rests on the readings, and what nobody said has no row here."""
    silent = dict(condition_rows(ReportConditions(), words))
    return ((name, text) for name, text in condition_rows(conditions, words) if text != silent.get(name))


def _errors(diagnosis: Diagnosis, words: Catalogue) -> dict[str, object]:
    errors, after = diagnosis.errors, diagnosis.after
    if errors is None or after is None:
        return {"histogram": None, "beyond": 0, "maps": None}
    before_mm, after_mm = _norms(errors.before_mm), _norms(errors.after_mm)
    known = np.isfinite(before_mm) & np.isfinite(after_mm)
    if not known.any():
        return {"histogram": None, "beyond": 0, "maps": None}
    picture, beyond = comparison(before_mm[known], after_mm[known], after.noise_mm, words)
    return {
        "histogram": picture,
        "histogram_seen": errors_sentence(before_mm[known], after_mm[known]),
        "beyond": beyond,
        "maps": error_maps(errors, words),
        "maps_seen": places_sentence(errors),
    }


def _norms(errors_mm: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(errors_mm, axis=1))


def _dependences(diagnosis: Diagnosis, words: Catalogue) -> tuple[DependenceBlock, ...]:
    numbered = enumerate(diagnosis.remaining.depends_on, 1)
    return tuple(_dependence(number, one, words) for number, one in numbered)


def _dependence(number: int, dependence: Dependence, words: Catalogue) -> DependenceBlock:
    name = words.name(dependence.variable)
    if dependence.curve is None:
        return DependenceBlock(dependence, name, None)
    curve = residual_curve(dependence.curve, f"left-{number}", of_cause=False, words=words)
    return DependenceBlock(dependence, name, curve, curve_sentence(dependence.curve, words))


def _proposal(measurement: NextMeasurement, words: Catalogue) -> Proposal:
    configurations = tuple(
        tuple(with_minus(format_fixed(angle, 2, "deg")) for angle in joints)
        for joints in measurement.configurations_deg
    )
    return Proposal(
        words.spoken(measurement.sentence), causes_listed(measurement.separates, words), configurations
    )


def added_table(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Table:
    """Return the parameters that the findings name, as the extended model holds them."""
    model = () if diagnosis.model is None else diagnosis.model.parameters
    known = {parameter.name: parameter for parameter in model}
    wanted = dict.fromkeys(name for finding in diagnosis.all_findings for name in finding.parameters)
    added = [known[name] for name in wanted if name in known]
    return parameter_table((parameter_cells(one, one.value, words) for one in added), words)


_WIDEST = 44  # letters of a name; the scale needs the rest


def gains(findings: tuple[Finding, ...], words: Catalogue = IN_ENGLISH) -> Markup | None:
    """Return one interval per finding on a common scale; None where fewer than two have a gain."""
    known = [(finding, finding.gain) for finding in findings if finding.gain is not None]
    if len(known) < 2:
        return None
    low, high = np.array([gain.interval_95_mm for _, gain in known]).T
    best = np.array([gain.rms_before_mm - gain.rms_after_mm for _, gain in known])
    rows = np.arange(len(known))[::-1]
    with page_style():
        figure = new_figure(8.0, 0.9 + 0.32 * len(known))
        axes = figure.add_subplot()
        axes.axvline(0.0, color=INK, linewidth=1.0)
        axes.hlines(rows, low, high, color=AFTER, linewidth=3.0, alpha=0.5)
        axes.plot(best, rows, "o", color=AFTER, markersize=6.0)
        causes = (cause_words(Cause(f.effect, f.subject), words) for f, _ in known)
        axes.set_yticks(rows, [label(cause, _WIDEST) for cause in causes])
        axes.set_ylim(-0.6, len(known) - 0.4)
        axes.grid(axis="y", visible=False)
        mark_axis(axes.xaxis, words.units.conversion("mm"))
        axes.set_xlabel(words.say("gains.axis"))
        return to_svg(figure, "gains", words.say("gains"), words)
