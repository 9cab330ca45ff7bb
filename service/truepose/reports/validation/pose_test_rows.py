"""A test of ISO 9283 as rows: figures with uncertainty, and the conditions that the standard wants stated."""

from collections.abc import Iterator
from dataclasses import dataclass

from truepose.exchange.models.document import file_factor, file_unit
from truepose.judgement.iso9283.characteristics import Characteristic
from truepose.judgement.iso9283.judged import CommandedBy, PoseTest
from truepose.reports.conditions import NOT_STATED, ReportConditions, condition_rows
from truepose.reports.rounding import rounded, uncertainty
from truepose.words.catalogue import IN_ENGLISH, english

_NAMES = {
    "AP": "pose accuracy",
    "RP": "pose repeatability",
    "vAP": "multi-directional pose accuracy variation",
    "AD": "distance accuracy",
    "RD": "distance repeatability",
    "dAP": "drift of pose accuracy",
    "dRP": "drift of pose repeatability",
}


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


def pose_test_rows(test: PoseTest) -> Iterator[PoseTestRow]:
    """Yield the figures of a test."""
    for commanded_by, figure in test.figures():
        yield _row(figure, commanded_by)


def _row(figure: Characteristic, commanded_by: CommandedBy | None) -> PoseTestRow:
    factor = file_factor(figure.unit)
    value, u = figure.value * factor, figure.standard_uncertainty * factor
    half_width = figure.symbol == "RD" or (figure.symbol == "RP" and figure.component != "l")
    return PoseTestRow(
        f"{figure.symbol} {figure.component}",
        _NAMES[figure.symbol],
        figure.clause,
        figure.subject,
        commanded_by or "",
        f"{'±' if half_width else ''}{rounded(value, u)}",
        uncertainty(u),
        file_unit(figure.unit),
        rounded(figure.noise * factor, u) if figure.noise else "",
        figure.visits,
        figure.component in {"p", "l"},
    )


def withheld_sentences(test: PoseTest) -> Iterator[str]:
    """Yield what the visits do not give, and why."""
    for one in test.identified.withheld:
        yield f"{one.symbol} of {one.subject}: {english(one.reason)}."


def stated_conditions(test: PoseTest | None, conditions: ReportConditions) -> tuple[tuple[str, str], ...]:
    """Return the conditions of a test, else of any readings; "not stated" where nobody said."""
    if test is None:
        return tuple(condition_rows(conditions))
    instruments = ", ".join(device.model or device.role for device in conditions.instruments)
    return (
        ("Standard", "ISO 9283:1998"),
        ("Poses and cycles", f"{test.poses} poses, {test.cycles} cycles"),
        ("Point of the tool", f"nest {test.nest}"),
        ("Measuring instrument", instruments or IN_ENGLISH.say(NOT_STATED)),
        *condition_rows(conditions),
    )
