"""A diagnosis on a terminal: one sentence a line, and a table of the errors before and after."""

from collections.abc import Iterator

from rich.table import Table

from truepose.domain.diagnosis import Diagnosis, Finding, Gain, NextMeasurement, Remaining
from truepose.domain.results import Statistics
from truepose.reports.causes import (
    SMALL_FINDINGS,
    causes_listed,
    place_words,
    printed_unit,
    worth_words,
)
from truepose.reports.causes_found.described import DescribedRow, described_rows, described_sentence
from truepose.reports.rounding import millimetres, p_value, with_uncertainty
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_HELD_OUT = {
    "validation": "readings kept for validation",
    "cross_validation": "nested cross-validation by configuration",
}


def diagnosis_lines(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Iterator[str]:
    """Yield the message first, then findings, what was withdrawn, what is left, and what to measure next."""
    yield words.spoken(diagnosis.message)
    for number, finding in enumerate(diagnosis.findings, start=1):
        yield f"{number}. {words.spoken(finding.sentence)}"
        yield from (f"   {line}" for line in _evidence(finding))
    if diagnosis.small:
        yield f"{SMALL_FINDINGS}:"
        yield from (f"   {words.spoken(finding.sentence)}" for finding in diagnosis.small)
    yield from (f"Withdrawn: {words.spoken(sentence)}" for sentence in diagnosis.withdrawn)
    left = words.spoken(diagnosis.remaining.sentence)
    if left not in words.spoken(diagnosis.message):  # the first line may have said it already
        yield left
    if diagnosis.remaining.depends_on:
        yield f"Depends on: {_depends_on(diagnosis.remaining)}."
    if diagnosis.remaining.described:
        yield described_sentence(diagnosis.remaining)
        yield from map(_described, described_rows(diagnosis.remaining.described))
    if diagnosis.findings and diagnosis.errors is not None:
        worst = diagnosis.errors.worst
        yield (
            f"Farthest off of the held-out readings: configuration {worst.config}, "
            f"{millimetres(worst.before_mm)} mm before, {millimetres(worst.after_mm)} mm after."
        )
    if diagnosis.noise is not None:
        yield f"Noise: {words.spoken(diagnosis.noise.sentence)}"
    for entry in diagnosis.next_measurements:
        yield from _next(entry, words)


def _evidence(finding: Finding) -> Iterator[str]:
    amplitude = with_uncertainty(finding.amplitude, finding.amplitude_standard_uncertainty)
    size = f"{amplitude} {printed_unit(finding.unit)}".rstrip()
    yield f"Amplitude {size}; {finding.confidence.value}, p {_p(finding.p_value)}."
    if finding.worth is not None:
        yield f"{place_words(finding)}; it moves the tool by {worth_words(finding.worth)}."
    yield _gain(finding.gain)
    if finding.confusable_with:
        yield f"These data cannot tell it from: {causes_listed(finding.confusable_with)}."


def _p(value: float) -> str:
    shown = p_value(value)
    return shown if shown.startswith("<") else f"= {shown}"


def _gain(gain: Gain | None) -> str:
    if gain is None:
        return "Gain: no held-out reading can show it."
    low, high = gain.interval_95_mm
    return (
        f"Gain on held-out readings: RMS {millimetres(gain.rms_before_mm)} mm without it, "
        f"{millimetres(gain.rms_after_mm)} mm with it "
        f"(95 % interval of the difference {millimetres(low)} to {millimetres(high)} mm)."
    )


def _depends_on(remaining: Remaining) -> str:
    return "; ".join(f"{entry.variable} (p {_p(entry.p_value)})" for entry in remaining.depends_on)


def _described(row: DescribedRow) -> str:
    return f"   {row.place}: missed by {row.own} mm RMS without it; it moves the tool by {row.worth}."


def _next(entry: NextMeasurement, words: Catalogue) -> Iterator[str]:
    yield f"Measure next: {words.spoken(entry.sentence)}"
    for joints in entry.configurations_deg:
        yield f"   joints {' '.join(f'{angle:.2f}' for angle in joints)} deg"


def errors_table(diagnosis: Diagnosis) -> Table | None:
    """Return the held-out errors before and after; None where nothing could be fitted."""
    if diagnosis.before is None or diagnosis.after is None:
        return None
    table = Table(
        title=f"{diagnosis.quantity.capitalize()} errors, mm", caption=_HELD_OUT[diagnosis.held_out]
    )
    table.add_column("model")
    for name in ("n", "mean", "rms", "sd", "max", "noise"):
        table.add_column(name, justify="right")
    for model, statistics in (("before", diagnosis.before), ("after", diagnosis.after)):
        table.add_row(model, str(statistics.n), *_figures(statistics))
    return table


def _figures(statistics: Statistics) -> Iterator[str]:
    values = (
        statistics.mean_mm,
        statistics.rms_mm,
        statistics.sd_mm,
        statistics.max_mm,
        statistics.noise_mm,
    )
    return (millimetres(value) for value in values)
