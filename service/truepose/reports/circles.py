"""A single-axis circle test: its report, its table as in the thesis, its sentences and its figures."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, message, together
from truepose.messages.units import Conversion, ConvertibleNumber
from truepose.reports.cover_page import Front
from truepose.reports.limits import NO_LIMIT, FigureNames, Limit, LimitedTest
from truepose.reports.report import Description, Report
from truepose.reports.rounding import format_rounded, millimetres
from truepose.reports.tables import Table, heads_of
from truepose.validation.circle_test import CircleTest, JointCircle
from truepose.validation.uncertainty import Figure

_HEADS: Final = (
    "circles.head.joint",
    "circles.head.nest",
    "circles.head.interval",
    "circles.head.increment",
    "circles.head.tangential",
    "circles.head.angular",
    "circles.head.backlash",
    "circles.head.radial",
    "circles.head.axial",
)
_NAMES: Final = FigureNames("front.circles", "front.circles.largest", "front.circles.bars")


@dataclass(frozen=True, slots=True)
class CircleReport(Report):
    """The circles of a robot's joints, held against a limit where one was set."""

    test: CircleTest
    robot: str
    limit: Limit = NO_LIMIT

    def described(self, words: Catalogue) -> Description:
        """Return the table, and each circle with its figure and its sentences."""
        from truepose.reports.figures.bands import tangential_figure  # the drawing library is slow to import

        circles = [
            (
                one,
                tangential_figure(one, words),
                [words.spoken(sentence) for sentence in circle_sentences(one)],
            )
            for one in self.test.circles
        ]
        shown = {
            "table": circle_table(self.test, words),
            "circles": circles,
            "withheld": [words.spoken(sentence) for sentence in withheld_sentences(self.test)],
        }
        front = circles_front(self.test, self.robot, self.limit, words)
        return Description(front.title, self.robot, "circles.html", shown, front)


def circles_front(test: CircleTest, robot: str, limit: Limit, words: Catalogue) -> Front:
    """Return whether the joints' tangential errors stay within a limit from end to end."""
    named = [
        (words.say("front.of_joint", joint=one.joint, nest=one.nest), one.tangential_range_mm)
        for one in test.circles
    ]
    title, lacks = words.say("circles.title", robot=robot), together(*withheld_sentences(test))
    return LimitedTest(title, robot, _NAMES, named, lacks).front(limit, words)


def circle_table(test: CircleTest, words: Catalogue) -> Table:
    """Return a row for each circle, with the columns of Table 2.3 (thesis of A. Nubiola, 2014) and more."""
    return Table(heads_of(words, *_HEADS), [*map(_row, test.circles)])


def _row(one: JointCircle) -> tuple[str, ...]:
    low, high = np.degrees(one.interval_rad)
    tangential = one.tangential_range_mm
    return (
        str(one.joint),
        str(one.nest),
        _between(low, high),
        ConvertibleNumber(partial(_step, float(np.degrees(one.increment_rad))), "deg"),
        format_rounded(tangential.value, tangential.standard_uncertainty, "mm"),
        _degrees(one.angular_range_rad),
        "" if one.backlash_rad is None else _degrees(one.backlash_rad),
        millimetres(one.radial_range_mm),
        millimetres(one.axial_range_mm),
    )


def circle_test_sentences(test: CircleTest) -> Iterator[Message]:
    """Yield what the circles say of the joints, and which sweeps give none."""
    for one in test.circles:
        yield message(
            "circles.of_joint", joint=one.joint, nest=one.nest, sentence=together(*circle_sentences(one))
        )
    yield from withheld_sentences(test)
    if any(not one.is_noise for one in test.circles):
        yield message("circles.gravity")


def withheld_sentences(test: CircleTest) -> Iterator[Message]:
    """Yield which sweeps give no circle, and why."""
    for lost in test.withheld:
        yield message("circles.of_joint", joint=lost.joint, nest=lost.nest, sentence=lost.reason)


def circle_sentences(one: JointCircle) -> Iterator[Message]:
    """Yield what a circle says of its joint."""
    yield _errors(one)
    yield _backlash(one.backlash_rad)
    if one.curve.gain is not None and one.curve.gain.is_seen:
        gain = one.curve.gain
        yield message("circles.gain", gain=gain.value, u=gain.standard_uncertainty)
    for wave in one.curve.waves:
        if wave.is_seen:
            amplitude, u = _in_degrees(wave.amplitude_rad)
            yield message("circles.wave", order=wave.order, amplitude_deg=amplitude, u_deg=u)
    if one.set_aside:
        yield message("circles.set_aside", configurations=one.set_aside)


def _errors(one: JointCircle) -> Message:
    size = one.tangential_range_mm
    angle, _ = _in_degrees(one.angular_range_rad)
    key = "circles.noise" if one.is_noise else "circles.errors"
    return message(key, range_mm=size.value, u_mm=size.standard_uncertainty, range_deg=angle)


def _backlash(gap: Figure | None) -> Message:
    if gap is None:
        return message("circles.one_sided")
    value, u = _in_degrees(gap)
    return message("circles.backlash" if gap.is_seen else "circles.no_backlash", gap_deg=value, u_deg=u)


def _in_degrees(figure: Figure) -> tuple[float, float]:
    return float(np.degrees(figure.value)), float(np.degrees(figure.standard_uncertainty))


def _degrees(figure: Figure) -> str:
    return format_rounded(*_in_degrees(figure), "deg")


def _step(value_deg: float, shown: Conversion) -> str:
    return shown.formatted(value_deg, ".4g")


def _between(low_deg: float, high_deg: float) -> str:
    ends = (low_deg, high_deg)
    return ConvertibleNumber(lambda shown: " … ".join(shown.formatted(end, ".0f") for end in ends), "deg")
