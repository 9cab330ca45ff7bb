"""A single-axis circle test in sentences and as the table of the thesis."""

from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
from rich.table import Table

from truepose.domain.sentences import Sentence, said, together
from truepose.judgement.circle.judged import CircleTest, JointCircle
from truepose.judgement.figure import Figure
from truepose.reports.wording.rounding import millimetres, rounded
from truepose.words.catalogue import Catalogue
from truepose.words.units import Conversion, Printed

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


def circle_heads(words: Catalogue) -> list[str]:
    """Return what stands above the columns of `circle_rows`."""
    return [words.say(head) for head in _HEADS]


def circle_rows(test: CircleTest) -> Iterator[tuple[str, ...]]:
    """Yield a row for each circle, with the columns of Table 2.3 (thesis of A. Nubiola, 2014) and more."""
    for one in test.circles:
        low, high = np.degrees(one.interval_rad)
        tangential = one.tangential_range_mm
        yield (
            str(one.joint),
            str(one.nest),
            _between(low, high),
            Printed(partial(_step, float(np.degrees(one.increment_rad))), "deg"),
            rounded(tangential.value, tangential.standard_uncertainty, "mm"),
            _degrees(one.angular_range_rad),
            "" if one.backlash_rad is None else _degrees(one.backlash_rad),
            millimetres(one.radial_range_mm),
            millimetres(one.axial_range_mm),
        )


def circle_table(test: CircleTest, words: Catalogue) -> Table:
    """Return the rows as a table of a terminal."""
    table = Table(padding=0)  # nine columns on a narrow terminal
    for head in circle_heads(words):
        table.add_column(head.replace(", ", ",\n"), justify="right")
    for row in circle_rows(test):
        table.add_row(*row)
    return table


def circle_test_sentences(test: CircleTest) -> Iterator[Sentence]:
    """Yield what the circles say of the joints, and which sweeps give none."""
    for one in test.circles:
        yield said(
            "circles.of_joint", joint=one.joint, nest=one.nest, sentence=together(*circle_sentences(one))
        )
    yield from withheld_sentences(test)
    if any(not one.is_noise for one in test.circles):
        yield said("circles.gravity")


def withheld_sentences(test: CircleTest) -> Iterator[Sentence]:
    """Yield which sweeps give no circle, and why."""
    for lost in test.withheld:
        yield said("circles.of_joint", joint=lost.joint, nest=lost.nest, sentence=lost.reason)


def circle_sentences(one: JointCircle) -> Iterator[Sentence]:
    """Yield what a circle says of its joint."""
    yield _errors(one)
    yield _backlash(one.backlash_rad)
    if one.curve.gain is not None and one.curve.gain.is_seen:
        gain = one.curve.gain
        yield said("circles.gain", gain=gain.value, u=gain.standard_uncertainty)
    for wave in one.curve.waves:
        if wave.is_seen:
            amplitude, u = _in_degrees(wave.amplitude_rad)
            yield said("circles.wave", order=wave.order, amplitude_deg=amplitude, u_deg=u)
    if one.set_aside:
        yield said("circles.set_aside", configurations=one.set_aside)


def _errors(one: JointCircle) -> Sentence:
    size = one.tangential_range_mm
    angle, _ = _in_degrees(one.angular_range_rad)
    key = "circles.noise" if one.is_noise else "circles.errors"
    return said(key, range_mm=size.value, u_mm=size.standard_uncertainty, range_deg=angle)


def _backlash(gap: Figure | None) -> Sentence:
    if gap is None:
        return said("circles.one_sided")
    value, u = _in_degrees(gap)
    return said("circles.backlash" if gap.is_seen else "circles.no_backlash", gap_deg=value, u_deg=u)


def _in_degrees(figure: Figure) -> tuple[float, float]:
    return float(np.degrees(figure.value)), float(np.degrees(figure.standard_uncertainty))


def _degrees(figure: Figure) -> str:
    return rounded(*_in_degrees(figure), "deg")


def _step(value_deg: float, shown: Conversion) -> str:
    return shown.formatted(value_deg, ".4g")


def _between(low_deg: float, high_deg: float) -> str:
    ends = (low_deg, high_deg)
    return Printed(lambda shown: " … ".join(shown.formatted(end, ".0f") for end in ends), "deg")
