"""A diagnosis on a terminal: one sentence a line, and a table of the errors before and after."""

from collections.abc import Iterator

from rich.table import Table

from truepose.domain.diagnosis import Diagnosis, Finding, Gain, NextMeasurement, Remaining
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text
from truepose.reports.cause_words import (
    causes_listed,
    confidence_word,
    place_words,
    printed_unit,
    worth_words,
)
from truepose.reports.diagnosis.report import errors_table
from truepose.reports.diagnosis.rows import DescribedRow, described_rows, described_sentence
from truepose.reports.error_tables import title_of
from truepose.reports.rounding import millimetres, p_value, with_uncertainty
from truepose.reports.tables import on_terminal
from truepose.validation.outcome import outcome_of

_HELD_OUT = {"validation": "terminal.validation", "cross_validation": "terminal.cross_validation"}


def diagnosis_lines(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Iterator[str]:
    """Yield outcome and message, then findings, what was withdrawn, what is left, what to measure next."""
    message, left = words.spoken(diagnosis.message), words.spoken(diagnosis.remaining.sentence)
    yield words.spoken(outcome_of(diagnosis))
    yield message
    for number, finding in enumerate(diagnosis.findings, start=1):
        yield f"{number}. {words.spoken(finding.sentence)}"
        yield from (f"   {line}" for line in _evidence(finding, words))
    if diagnosis.small:
        yield words.say("terminal.small")
        yield from (f"   {words.spoken(finding.sentence)}" for finding in diagnosis.small)
    yield from (_with(words, "terminal.withdrawn", sentence) for sentence in diagnosis.withdrawn)
    if left not in message:  # the first line may have said it already
        yield left
    yield from _rest(diagnosis, words)
    if diagnosis.noise is not None:
        yield _with(words, "terminal.noise", diagnosis.noise.sentence)
    for entry in diagnosis.next_measurements:
        yield from _next(entry, words)


def _with(words: Catalogue, key: str, sentence: Text) -> str:
    return words.say(key, sentence=sentence)


def _rest(diagnosis: Diagnosis, words: Catalogue) -> Iterator[str]:
    """Yield what is left: its variables, what is described of it, and where it is largest."""
    remaining = diagnosis.remaining
    if remaining.depends_on:
        variables = words.listed([*_variables(remaining, words)], "semicolons")
        yield words.say("terminal.depends", variables=variables)
    if remaining.described:
        yield described_sentence(remaining, words)
        yield from (_described(row, words) for row in described_rows(remaining.described, words))
    if diagnosis.findings and diagnosis.errors is not None:
        worst = diagnosis.errors.worst
        before, after = millimetres(worst.before_mm), millimetres(worst.after_mm)
        yield words.say("terminal.farthest", config=worst.config, before=before, after=after)


def _evidence(finding: Finding, words: Catalogue) -> Iterator[str]:
    amplitude = with_uncertainty(finding.amplitude, finding.amplitude_standard_uncertainty)
    size = f"{amplitude} {printed_unit(finding.unit)}".rstrip()
    confidence = confidence_word(finding.confidence, words)
    yield words.say("terminal.amplitude", size=size, confidence=confidence, p=_p(finding.p_value))
    if finding.worth is not None:
        place, worth = place_words(finding, words), worth_words(finding.worth, words)
        yield words.say("terminal.place", place=place, worth=worth)
    yield _gain(finding.gain, words)
    if finding.confusable_with:
        yield words.say("terminal.rivals", rivals=causes_listed(finding.confusable_with, words))


def _p(value: float) -> str:
    shown = p_value(value)
    return shown if shown.startswith("<") else f"= {shown}"


def _gain(gain: Gain | None, words: Catalogue) -> str:
    if gain is None:
        return words.say("terminal.no_gain")
    low, high = map(millimetres, gain.interval_95_mm)
    difference = millimetres(gain.rms_before_mm - gain.rms_after_mm)
    return words.say("terminal.gain", difference=difference, low=low, high=high)


def _variables(remaining: Remaining, words: Catalogue) -> Iterator[str]:
    for entry in remaining.depends_on:
        yield words.say("terminal.variable", variable=entry.variable, p=_p(entry.p_value))


def _described(row: DescribedRow, words: Catalogue) -> str:
    return "   " + words.say("terminal.described", place=row.place, own=row.own, worth=row.worth)


def _next(entry: NextMeasurement, words: Catalogue) -> Iterator[str]:
    yield _with(words, "terminal.next", entry.sentence)
    for joints in entry.configurations_deg:
        yield "   " + words.say("terminal.joints", angles=" ".join(f"{angle:.2f}" for angle in joints))


def errors_on_terminal(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Table | None:
    """Return the held-out errors before and after; None where nothing could be fitted."""
    errors = errors_table(diagnosis, words)
    if errors is None:
        return None
    shown = on_terminal(errors, words.say(title_of(diagnosis)))
    shown.caption = words.say(_HELD_OUT[diagnosis.held_out])
    return shown
