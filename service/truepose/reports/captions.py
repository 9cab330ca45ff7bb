"""Captions: what a figure shows, in a sentence from its own statistics: something, or nothing.

In residuals over joint angles each joint, direction and order is fitted alone by least squares. A wave cos(k
q), sin(k q) has two degrees of freedom; whether it is more than noise is told by the F distribution with 2
and m degrees of freedom, whose tail is (1 + 2 F / m)^(-m/2) (Abramowitz and Stegun, 26.6.4). As many waves as
are tried, so much smaller must the chance be (Bonferroni).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.diagnosis import Cause, Curve, CurvePoints, Finding, HeldOutErrors, Spectrum
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, Text, message, together
from truepose.reports.cause_words import cause_words, printed_unit
from truepose.reports.diagnosis.cause_map import CauseMap
from truepose.reports.figures.joint_residuals import residuals_by_joint
from truepose.reports.rounding import format_rounded, millimetres
from truepose.validation.validate import distance_from_axis_1

_FAR: Final = 5.0  # typical (median) errors
_MOST: Final = 0.95


def errors_sentence(before_mm: FloatArray, after_mm: FloatArray) -> Text:
    """Return where nearly all errors lie before and after, and which lie far out.

    Parameters
    ----------
    before_mm, after_mm : ndarray, shape (n,)
        Sizes of the errors of the same readings.
    """
    before, after = (float(np.quantile(sizes, _MOST)) for sizes in (before_mm, after_mm))
    if np.array_equal(before_mm, after_mm):
        key = "seen.errors.same"
    else:
        key = "seen.errors.better" if after < before else "seen.errors.no_better"
    told = message(key, before=millimetres(before), after=millimetres(after))
    far = int((after_mm > _FAR * np.median(after_mm)).sum())
    if not far:
        return told
    return together(told, message("seen.errors.far_one" if far == 1 else "seen.errors.far", number=far))


def distances_sentence(mean_mm: float, positive_share: float, pairs: int) -> Message:
    """Return whether distances err to one side.

    Pairs share points: the share is believed only where it is far from one half.
    """
    if pairs < 1 or abs(positive_share - 0.5) < 0.15:
        return message("seen.distances.nothing")
    percent = 100.0 * max(positive_share, 1.0 - positive_share)
    key = "seen.distances.long" if positive_share > 0.5 else "seen.distances.short"
    return message(key, percent=percent, mean=millimetres(abs(mean_mm)))


_CLEAR: Final = 4.0  # standard deviations of what chance gives
_FEWEST: Final = 12  # readings
_COVERED: Final = 2.0  # times what the model is uncertain by
_DEPENDENT: Final = 2.0  # by which pairs of neighbours, who share readings, vary more than independent ones


def reach_sentence(reach_mm: FloatArray, error_mm: FloatArray) -> Message:
    """Return whether errors grow with the distance from axis 1, by ranks (Spearman).

    Parameters
    ----------
    reach_mm, error_mm : ndarray, shape (n,)
        Distance from axis 1, and size of the error there.
    """
    n = len(reach_mm)
    if n < _FEWEST or np.ptp(reach_mm) <= 0.0:
        return message("seen.reach.few")
    if np.ptp(error_mm) <= 0.0:
        return message("seen.reach.nothing")
    ranks = np.array([_ranks(values) for values in (reach_mm, error_mm)])
    correlation = float(np.corrcoef(ranks)[0, 1])
    if abs(correlation) * np.sqrt(n - 1) < _CLEAR:
        return message("seen.reach.nothing")
    near, far = (error_mm[part].mean() for part in np.array_split(np.argsort(reach_mm), 3)[::2])
    key = "seen.reach.grows" if correlation > 0.0 else "seen.reach.falls"
    return message(key, near=millimetres(float(near)), far=millimetres(float(far)))


def _ranks(values: FloatArray) -> FloatArray:
    ordered = np.sort(values)
    # Equal values share a rank: in the order they come, they would correlate with where they were read.
    first, end = np.searchsorted(ordered, values, "left"), np.searchsorted(ordered, values, "right")
    return np.asarray(0.5 * (first + end), dtype=float)


def neighbours_sentence(position_mm: FloatArray, error_mm: FloatArray, model_share: float = 0.0) -> Message:
    """Return whether errors of neighbours point alike: what no noise does.

    Parameters
    ----------
    position_mm, error_mm : ndarray, shape (n, 3)
    model_share : float
        Share of the mean square that the uncertainty of the model's own parameters explains: it is alike for
        neighbours, and no finding.
    """
    size = np.linalg.norm(error_mm, axis=1)
    known = size > 0.0
    if known.sum() < _FEWEST:
        return message("seen.space.few")
    place, direction = position_mm[known], error_mm[known] / size[known, None]
    cosine = float((direction * direction[_nearest(place)]).sum(axis=1).mean())
    # The cosine of two directions by chance has mean 0 and variance 1/3.
    chance = _CLEAR / np.sqrt(3.0 * len(place) / _DEPENDENT)
    if cosine < chance + _COVERED * model_share:
        return message("seen.space.nothing")
    return message("seen.space.alike", cosine=cosine)


def _nearest(place: FloatArray) -> IntArray:
    """Return the nearest other place of each; where several stand at one place, another one of them."""
    from scipy.spatial import KDTree

    found = np.asarray(KDTree(place).query(place, k=2)[1])
    return np.where(found[:, 0] == np.arange(len(place)), found[:, 1], found[:, 0])


_ORDERS: Final = (1, 2, 3, 4)  # waves per turn; gears' own cycles are the diagnosis' business
_LEAST_PART: Final = 0.6  # of a wave's period that the joint must have covered
_CHANCE: Final = 1e-3  # of a sentence where there is only noise
_RMS: Final = 2.0**0.5  # amplitude of a wave over its root mean square


@dataclass(frozen=True, slots=True)
class Wave:
    """A wave of one joint."""

    joint: int  # from 1
    order: int
    amplitude_mm: float
    chance: float  # that noise alone explains as much


def joints_sentence(joints_rad: FloatArray, residual_mm: FloatArray, model_u_mm: float = 0.0) -> Message:
    """Return the largest wave that is more than noise, and how many joints have one.

    Parameters
    ----------
    joints_rad : ndarray, shape (n, J)
    residual_mm : ndarray, shape (J, n, d)
        As each joint sees it, `residuals_by_joint`.
    model_u_mm : float
        Standard uncertainty of the model's own predictions, per axis: what its parameters miss is smooth over
        the joints, and no finding.
    """
    tried = list(_waves(joints_rad, residual_mm))
    known = [wave for wave in tried if wave.amplitude_mm > _RMS * model_u_mm]
    found = [wave for wave in known if wave.chance * len(tried) < _CHANCE]
    if not found:
        return message("seen.joints.nothing")
    largest = max(found, key=lambda wave: wave.amplitude_mm)
    others = len({wave.joint for wave in found}) - 1
    key = "seen.joints.wave" if not others else "seen.joints.waves"
    return message(
        key,
        joint=f"joint {largest.joint}",
        order=largest.order,
        peak_mm=2.0 * largest.amplitude_mm,
        others=others,
    )


def _waves(joints_rad: FloatArray, residual_mm: FloatArray) -> Iterator[Wave]:
    n = len(joints_rad)
    if n < _FEWEST:
        return
    for joint, (angle, residual) in enumerate(zip(joints_rad.T, residual_mm, strict=True), start=1):
        for order in _ORDERS:
            if np.ptp(angle) * order >= _LEAST_PART * 2.0 * np.pi:
                for component in residual.T:
                    yield _wave(joint, order, angle, component)


def _wave(joint: int, order: int, angle: FloatArray, residual: FloatArray) -> Wave:
    """Fit mean and wave; the mean alone is what it is held against."""
    rows = np.column_stack([np.cos(order * angle), np.sin(order * angle)])
    rows, residual = rows - rows.mean(axis=0), residual - residual.mean()
    coefficients, *_ = np.linalg.lstsq(rows, residual, rcond=None)
    total, left = float(residual @ residual), float(((residual - rows @ coefficients) ** 2).sum())
    # Less mean, cosine and sine.
    freedom = len(residual) - 3
    ratio = left / total if total > 0.0 else 1.0  # (1 + 2 F / m)^-1
    return Wave(joint, order, float(np.hypot(*coefficients)), ratio ** (freedom / 2.0))


def figure_captions(judged: Assessment) -> dict[str, Text]:
    """Return a sentence for histogram, reach, joints and arrows."""
    before, after = np.linalg.norm(judged.nominal_mm, axis=1), np.linalg.norm(judged.identified_mm, axis=1)
    reach = distance_from_axis_1(judged.identified.state.chain)
    return {
        "histogram": errors_sentence(before, after),
        "reach": reach_sentence(reach, after),
        "joints": joints_sentence(
            judged.stops.joints_rad, residuals_by_joint(judged), float(np.sqrt(judged.variance.mean()))
        ),
        "space": _space(judged),
    }


def _space(judged: Assessment) -> Text:
    """Return what arrows show; those of lengths lie along the bar, whatever the error."""
    if judged.block.quantity == "length":
        return ""
    vectors = judged.vectors_mm(judged.identified_mm)
    share = float(judged.variance.mean() / np.maximum((vectors**2).mean(), 1e-12))
    return neighbours_sentence(judged.position_mm, vectors, min(share, 1.0))


_CHANCE_OF_A_LINE: Final = 1e-3  # of a line that explains as much of noise alone
_FEWEST_PLACES: Final = 12  # readings
_SEEN: Final = 3.0  # standard uncertainties of a wave
_LEAST_SHARE: Final = 0.01  # of all that is told; the map writes no smaller one


def map_sentence(found: CauseMap) -> Text:
    """Return where most of it acts; nothing where no share was told."""
    shown = [cell for cell in found.cells if cell.share >= _LEAST_SHARE]
    if not shown:
        return message("seen.map.nothing")
    most = max(shown, key=lambda cell: cell.share)
    others = len(shown) - 1
    key = "seen.map.most" if others else "seen.map.only"
    return message(key, percent=100.0 * most.share, where=most.where, over=most.over, others=others)


def curve_sentence(curve: Curve, words: Catalogue) -> Text:
    """Return how far the line goes, and what it explains: of readings that were never fitted where there are.

    The chance is that of an F test with two degrees of freedom, as in `seen.joints`.
    """
    unseen = curve.unseen if curve.unseen is not None and len(curve.unseen.x) >= _FEWEST_PLACES else None
    points = unseen or CurvePoints(curve.x, curve.residual, curve.standard_uncertainty)
    known = np.isfinite([points.x, points.residual, points.standard_uncertainty]).all(axis=0)
    known &= points.standard_uncertainty > 0.0
    n = int(known.sum())
    if n < _FEWEST_PLACES or not curve.line_x.size:
        return message("seen.curve.few")
    left = _share_left(curve, points, known)
    if left >= 1.0 or left ** (n / 2.0) > _CHANCE_OF_A_LINE:
        return message("seen.curve.nothing")
    travel, unit = float(np.ptp(curve.line)), printed_unit(curve.quantity_unit)
    return message(
        "seen.curve.follows" if unseen is None else "seen.curve.follows_unseen",
        travel=words.units.quantity(format_rounded(travel, travel / 10.0, unit), unit),
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
        return message("seen.spectrum.nothing")
    at = int(np.argmax(np.where(seen, spectrum.amplitude_deg, 0.0)))
    others = int(seen.sum()) - 1
    key = "seen.spectrum.several" if others else "seen.spectrum.one"
    amplitude = format_rounded(
        float(spectrum.amplitude_deg[at]), float(spectrum.standard_uncertainty_deg[at]), "deg"
    )
    return message(key, order=float(spectrum.order[at]), amplitude=amplitude, others=others)


def gains_sentence(findings: Sequence[Finding], words: Catalogue) -> Text:
    """Return which finding brings most, and of how many the interval reaches 0."""
    known = [(finding, finding.gain) for finding in findings if finding.gain is not None]
    if not known:
        return ""
    best, gain = max(known, key=lambda one: one[1].rms_before_mm - one[1].rms_after_mm)
    open_ones = sum(one.interval_95_mm[0] <= 0.0 for _, one in known)
    most = message(
        "seen.gains.most",
        cause=cause_words(Cause(best.effect, best.subject), words),
        gain=millimetres(gain.rms_before_mm - gain.rms_after_mm),
    )
    return together(
        most, message("seen.gains.open", number=open_ones) if open_ones else message("seen.gains.all")
    )


def places_sentence(errors: HeldOutErrors) -> Message:
    """Return whether the errors that are left belong to a place; of lengths, whether they err to one side."""
    kept = np.isfinite(errors.after_mm).all(axis=1) & np.isfinite(errors.position_mm).all(axis=1)
    after = errors.after_mm[kept]
    if after.shape[1] > 1:
        return neighbours_sentence(errors.position_mm[kept], after)
    if not len(after):
        return message("seen.space.few")
    return distances_sentence(float(after.mean()), float((after > 0.0).mean()), len(after))
