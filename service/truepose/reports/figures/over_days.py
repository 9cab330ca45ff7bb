"""What changes over days: the courses of quantities, and a change that passes a limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final, Literal

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import FloatArray, IntArray
from truepose.messages.catalogue import Catalogue
from truepose.reports.cause_words import printed_unit
from truepose.reports.figures.svg_rendering import (
    AFTER,
    BEFORE,
    MUTED,
    label,
    mark_axis,
    new_figure,
    page_style,
    to_svg,
)

_COLOURS: Final = (BEFORE, AFTER, MUTED)
_TICKS: Final = 6
_LABEL: Final = 26  # letters in a line
_ALONE_DAYS: Final = 30.0  # shown about a single day


@dataclass(frozen=True, slots=True)
class Course:
    """One quantity over the days; where it was not seen it is NaN."""

    name: str
    value: FloatArray  # (n,)
    low: FloatArray  # (n,) ends of its band
    high: FloatArray  # (n,)


def course_figure(
    days: Sequence[str],
    courses: Sequence[Course],
    quantity: str,
    unit: str,
    ident: str,
    description: str,
    words: Catalogue,
) -> Markup:
    """Draw quantities over days (n,), ISO 8601; each name must be told apart by `ident` on one page."""
    when = np.array([date.fromisoformat(day[:10]).toordinal() for day in days])
    with page_style():
        figure = new_figure(8.0, 2.5)
        axes = figure.add_subplot()
        for course, colour in zip(courses, _COLOURS, strict=False):
            far = np.nan_to_num(np.stack([course.value - course.low, course.high - course.value]))
            axes.errorbar(
                when,
                course.value,
                np.maximum(far, 0.0),
                fmt=".-",
                color=colour,
                capsize=3.0,
                label=course.name,
            )
        _days(axes, when)
        conversion = words.units.conversion(unit)
        axes.set_ylabel(label(quantity, _LABEL, printed_unit(conversion.symbol)))
        mark_axis(axes.yaxis, conversion)
        if len(courses) > 1:
            figure.legend(loc="outside upper left", ncols=len(courses))
        return to_svg(figure, ident, description, words)


def _days(axes: Axes, when: IntArray) -> None:
    """Name some of the days that were measured on, and give a single one room."""
    known = np.unique(when)
    room = 0.04 * float(np.ptp(known)) or _ALONE_DAYS
    axes.set_xlim(float(known[0]) - room, float(known[-1]) + room)
    named = known[np.unique(np.linspace(0, known.size - 1, min(_TICKS, known.size)).round().astype(int))]
    _name_days(axes, named)


_BAND: Final = 1.96  # standard uncertainties of 95 %
_BEYOND: Final = 2.0  # of the months that were measured, shown after the last of them


@dataclass(frozen=True, slots=True)
class Growth:
    """A change; days are `date.toordinal`."""

    first: float  # day
    day: FloatArray  # (n,) later ones
    size_mm: FloatArray  # (n,) from the first
    u_mm: FloatArray  # (n,)
    kind: Literal["linear", "step", "day"]
    since: float
    named_mm: float  # at the end
    named_u_mm: float
    limit_mm: float
    passed: tuple[float, float] | None  # days of 5 and 95 %


def growth_figure(growth: Growth, ident: str, description: str, words: Catalogue) -> Markup:
    """Draw a change with its band, the limit, and the days within which that is passed."""
    with page_style():
        figure = new_figure(8.0, 2.8)
        axes = figure.add_subplot()
        _draw_named(axes, growth, words.say("fleet.course.named"))
        axes.errorbar(
            np.append(growth.first, growth.day),
            np.append(0.0, growth.size_mm),
            np.append(0.0, _BAND * growth.u_mm),
            fmt=".",
            color=BEFORE,
            capsize=3.0,
        )
        axes.axhline(growth.limit_mm, color=MUTED, linestyle="--", label=words.say("fleet.course.limit"))
        _limit(axes, growth)
        _growth_days(axes, growth)
        conversion = words.units.conversion("mm")
        axes.set_ylabel(label(words.say("fleet.course.size"), _LABEL, printed_unit(conversion.symbol)))
        mark_axis(axes.yaxis, conversion)
        figure.legend(loc="outside upper left", ncols=2)
        return to_svg(figure, ident, description, words)


def _end(growth: Growth) -> float:
    """Return the last day that is shown: that of 95 %, if it is not far."""
    last = float(growth.day[-1])
    most = last + _BEYOND * (last - growth.first)
    wanted = last if growth.passed is None else growth.passed[1]
    return float(np.clip(wanted, last, most))


def _draw_named(axes: Axes, growth: Growth, name: str) -> None:
    end = _end(growth) if growth.kind == "linear" else float(growth.day[-1])
    if growth.kind == "linear":
        day = np.array([growth.since, end])
        share = (day - growth.since) / (float(growth.day[-1]) - growth.since)
    else:
        day = np.array([growth.first, growth.since, growth.since, end])
        share = np.array([0.0, 0.0, 1.0, 1.0])
    if growth.kind == "day":
        day, share = np.array([growth.since - 0.5, growth.since + 0.5]), np.ones(2)
    size, u = growth.named_mm * share, _BAND * growth.named_u_mm * share
    axes.fill_between(day, size - u, size + u, color=AFTER, alpha=0.2, linewidth=0.0)
    axes.plot(day, size, color=AFTER, label=name)


def _limit(axes: Axes, growth: Growth) -> None:
    if growth.passed is None:
        return
    early, late = (float(np.clip(day, growth.first, _end(growth))) for day in growth.passed)
    axes.plot(
        [early, late], [growth.limit_mm] * 2, color=MUTED, linewidth=6.0, alpha=0.5, solid_capstyle="butt"
    )


def _growth_days(axes: Axes, growth: Growth) -> None:
    end = _end(growth)
    room = 0.04 * (end - growth.first)
    axes.set_xlim(growth.first - room, end + room)
    named = np.linspace(growth.first, end, _TICKS).round().astype(int)
    _name_days(axes, named)


def _name_days(axes: Axes, days: IntArray) -> None:
    axes.set_xticks(days.tolist(), [date.fromordinal(int(day)).isoformat() for day in days])
