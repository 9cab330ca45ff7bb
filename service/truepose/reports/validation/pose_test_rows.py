"""A test of ISO 9283 as rows: figures with uncertainty, and the conditions that the standard wants stated."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.exchange.models.document import file_factor, file_unit
from truepose.judgement.iso9283.characteristics import Characteristic
from truepose.judgement.iso9283.judged import CommandedBy, PoseTest
from truepose.reports.conditions import NOT_STATED, ReportConditions, condition_rows
from truepose.reports.rounding import rounded, uncertainty
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MEANINGS = {
    "AP": "pose_test.AP",
    "RP": "pose_test.RP",
    "vAP": "pose_test.vAP",
    "AD": "pose_test.AD",
    "RD": "pose_test.RD",
    "dAP": "pose_test.dAP",
    "dRP": "pose_test.dRP",
}
_MODELS: dict[CommandedBy, str] = {"nominal": "model.nominal", "identified": "model.identified"}


@dataclass(frozen=True, slots=True)
class PoseTestRow:
    """A figure as printed."""

    name: str
    meaning: str
    clause: str
    subject: str
    commanded_by: str
    value: str
    u: str
    unit: str
    noise: str  # empty where the instrument's scatter averages out
    visits: int
    whole: bool  # no component of another figure


def pose_test_rows(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Iterator[PoseTestRow]:
    """Yield the figures of a test."""
    for commanded_by, figure in test.figures():
        yield _row(figure, commanded_by, words)


def _row(figure: Characteristic, commanded_by: CommandedBy | None, words: Catalogue) -> PoseTestRow:
    factor = file_factor(figure.unit)
    value, u = figure.value * factor, figure.standard_uncertainty * factor
    half_width = figure.symbol == "RD" or (figure.symbol == "RP" and figure.component != "l")
    return PoseTestRow(
        f"{figure.symbol} {figure.component}",
        words.say(_MEANINGS[figure.symbol]),
        figure.clause,
        figure.subject,
        words.say(_MODELS[commanded_by]) if commanded_by else "",
        f"{'±' if half_width else ''}{rounded(value, u)}",
        uncertainty(u),
        file_unit(figure.unit),
        rounded(figure.noise * factor, u) if figure.noise else "",
        figure.visits,
        figure.component in {"p", "l"},
    )


def withheld_sentences(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Iterator[str]:
    """Yield what the visits do not give, and why."""
    for one in test.identified.withheld:
        yield words.say("pose_test.withheld.one", symbol=one.symbol, subject=one.subject, reason=one.reason)


def stated_conditions(
    test: PoseTest | None, conditions: ReportConditions, words: Catalogue = IN_ENGLISH
) -> tuple[tuple[str, str], ...]:
    """Return the conditions of a test, else of any readings; "not stated" where nobody said."""
    if test is None:
        return tuple(condition_rows(conditions, words))
    say = words.say
    instruments = ", ".join(device.model or words.name(device.role) for device in conditions.instruments)
    return (
        (say("pose_test.standard"), "ISO 9283:1998"),
        (say("pose_test.cycles"), say("pose_test.cycles.value", poses=test.poses, cycles=test.cycles)),
        (say("pose_test.point"), say("pose_test.point.value", nest=test.nest)),
        (say("pose_test.instrument"), instruments or say(NOT_STATED)),
        *condition_rows(conditions, words),
    )
