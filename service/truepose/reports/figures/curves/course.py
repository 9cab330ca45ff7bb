"""Values over the days on which a robot was measured, with their 95 % bands."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import FloatArray, IntArray
from truepose.reports.figures.canvas import (
    AFTER,
    BEFORE,
    MUTED,
    label,
    marked_in,
    new_figure,
    page_style,
    to_svg,
)
from truepose.reports.wording.causes import printed_unit
from truepose.words.catalogue import Catalogue

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
        marked_in(axes.yaxis, conversion)
        if len(courses) > 1:
            figure.legend(loc="outside upper left", ncols=len(courses))
        return to_svg(figure, ident, description)


def _days(axes: Axes, when: IntArray) -> None:
    """Name some of the days that were measured on, and give a single one room."""
    known = np.unique(when)
    room = 0.04 * float(np.ptp(known)) or _ALONE_DAYS
    axes.set_xlim(float(known[0]) - room, float(known[-1]) + room)
    named = known[np.unique(np.linspace(0, known.size - 1, min(_TICKS, known.size)).round().astype(int))]
    axes.set_xticks(named.tolist(), [date.fromordinal(int(day)).isoformat() for day in named])
