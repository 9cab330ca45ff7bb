"""What each finding takes off the held-out errors, with its interval."""

import numpy as np
from markupsafe import Markup

from truepose.domain.results.causes import Cause
from truepose.domain.results.diagnosis import Finding
from truepose.reports.figures.canvas import AFTER, INK, label, marked_in, new_figure, page_style, to_svg
from truepose.reports.wording.causes import cause_words
from truepose.words.catalogue import IN_ENGLISH, Catalogue

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
        marked_in(axes.xaxis, words.units.conversion("mm"))
        axes.set_xlabel(words.say("gains.axis"))
        return to_svg(figure, "gains", words.say("gains"))
