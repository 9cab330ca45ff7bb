"""What the figures of a diagnosis show, in sentences from the figures' own numbers."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray
from truepose.domain.results.causes import Cause, Spectrum
from truepose.domain.results.diagnosis import Curve, CurvePoints, Finding, HeldOutErrors
from truepose.domain.sentences import Sentence, Text, said, together
from truepose.reports.causes_found.cause_map import CauseMap
from truepose.reports.seen.errors import distances_sentence
from truepose.reports.seen.places import neighbours_sentence
from truepose.reports.wording.causes import cause_words, printed_unit
from truepose.reports.wording.rounding import millimetres, rounded
from truepose.words.catalogue import Catalogue

_CHANCE: Final = 1e-3  # of a line that explains as much of noise alone
_FEWEST: Final = 12  # readings
_SEEN: Final = 3.0  # standard uncertainties of a wave
_LEAST_SHARE: Final = 0.01  # of all that is told; the map writes no smaller one


def map_sentence(found: CauseMap) -> Text:
    """Return where most of it acts; nothing where no share was told."""
    shown = [cell for cell in found.cells if cell.share >= _LEAST_SHARE]
    if not shown:
        return said("seen.map.nothing")
    most = max(shown, key=lambda cell: cell.share)
    others = len(shown) - 1
    key = "seen.map.most" if others else "seen.map.only"
    return said(key, percent=100.0 * most.share, where=most.where, over=most.over, others=others)


def curve_sentence(curve: Curve, words: Catalogue) -> Text:
    """Return how far the line goes, and what it explains: of readings that were never fitted where there are.

    The chance is that of an F test with two degrees of freedom, as in `seen.joints`.
    """
    unseen = curve.unseen if curve.unseen is not None and len(curve.unseen.x) >= _FEWEST else None
    points = unseen or CurvePoints(curve.x, curve.residual, curve.standard_uncertainty)
    known = np.isfinite([points.x, points.residual, points.standard_uncertainty]).all(axis=0)
    known &= points.standard_uncertainty > 0.0
    n = int(known.sum())
    if n < _FEWEST or not curve.line_x.size:
        return said("seen.curve.few")
    left = _share_left(curve, points, known)
    if left >= 1.0 or left ** (n / 2.0) > _CHANCE:
        return said("seen.curve.nothing")
    travel, unit = float(np.ptp(curve.line)), printed_unit(curve.quantity_unit)
    return said(
        "seen.curve.follows" if unseen is None else "seen.curve.follows_unseen",
        travel=words.units.quantity(rounded(travel, travel / 10.0, unit), unit),
        percent=100.0 * (1.0 - left),
        readings=n,
    )


def _share_left(curve: Curve, points: CurvePoints, known: BoolArray) -> float:
    """Return the mean square that the line leaves over that without it, by weight."""
    line = np.interp(points.x, curve.line_x, curve.line)[known]
    residual, u = points.residual[known], points.standard_uncertainty[known]
    whole = float((residual**2 / u**2).sum())
    return float(((residual - line) ** 2 / u**2).sum()) / whole if whole > 0.0 else 1.0


def spectrum_sentence(spectrum: Spectrum) -> Text:
    """Return the largest wave beyond its uncertainty, and how many others there are."""
    seen = spectrum.amplitude_deg > _SEEN * spectrum.standard_uncertainty_deg
    if not seen.any():
        return said("seen.spectrum.nothing")
    at = int(np.argmax(np.where(seen, spectrum.amplitude_deg, 0.0)))
    others = int(seen.sum()) - 1
    key = "seen.spectrum.several" if others else "seen.spectrum.one"
    amplitude = rounded(
        float(spectrum.amplitude_deg[at]), float(spectrum.standard_uncertainty_deg[at]), "deg"
    )
    return said(key, order=float(spectrum.order[at]), amplitude=amplitude, others=others)


def gains_sentence(findings: Sequence[Finding], words: Catalogue) -> Text:
    """Return which finding brings most, and of how many the interval reaches 0."""
    known = [(finding, finding.gain) for finding in findings if finding.gain is not None]
    if not known:
        return ""
    best, gain = max(known, key=lambda one: one[1].rms_before_mm - one[1].rms_after_mm)
    open_ones = sum(one.interval_95_mm[0] <= 0.0 for _, one in known)
    most = said(
        "seen.gains.most",
        cause=cause_words(Cause(best.effect, best.subject), words),
        gain=millimetres(gain.rms_before_mm - gain.rms_after_mm),
    )
    return together(most, said("seen.gains.open", number=open_ones) if open_ones else said("seen.gains.all"))


def places_sentence(errors: HeldOutErrors) -> Sentence:
    """Return whether the errors that are left belong to a place; of lengths, whether they err to one side."""
    kept = np.isfinite(errors.after_mm).all(axis=1) & np.isfinite(errors.position_mm).all(axis=1)
    after = errors.after_mm[kept]
    if after.shape[1] > 1:
        return neighbours_sentence(errors.position_mm[kept], after)
    if not len(after):
        return said("seen.space.few")
    return distances_sentence(float(after.mean()), float((after > 0.0).mean()), len(after))
