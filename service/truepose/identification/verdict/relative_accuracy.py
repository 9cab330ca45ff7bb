"""Errors of models beyond single readings: relative to any base, of turns, of lengths by positions.

*Relative accuracy* is what is left of position errors once the base may stand anywhere. An absolute figure
counts where the model believes the robot to stand, a relative one does not (thesis of A. Nubiola, 2014,
section 1.1): whoever sets up a work object by the robot itself sees the relative one. With wanted places w
and places p that were read,

    e_n = p_n - (R w_n + t)        R, t the rigid motion of least sum |e_n|^2 (`kinematics.frames`)

*Positions judge a model of lengths*, whose frame lengths alone leave open. Two answers: tied to the world by
the cups that a tracker measured there, and after the best rigid alignment. Neither the cups nor the positions
have a part in the identification.
"""

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, CupReadings, PointReadings, Readings
from truepose.domain.identification import (
    Anchor,
    Model,
    NominalAndIdentified,
    PositionsJudged,
    Statistics,
    TurnPair,
    TurnStatistics,
)
from truepose.identification.model.estimates import (
    Estimate,
    identified_anchors,
    identified_estimate,
    nominal_estimate,
)
from truepose.identification.verdict.judge import (
    Assessment,
    expected_noise_mm,
    judge,
    mean_norm,
    statistics,
)
from truepose.kinematics.frames import rigid_alignment

if TYPE_CHECKING:
    from truepose.identification.observations.poses import OrientationBlock


_FEWEST: Final = 4  # three places on a plane are aligned to almost nothing


def relative_errors(judged: Assessment) -> NominalAndIdentified | None:
    """Return the statistics after the best rigid alignment.

    Parameters
    ----------
    judged : Assessment

    Returns
    -------
    NominalAndIdentified or None
        [mm]; None of lengths, of fewer than four readings, or of places on a line.
    """
    places = judged.block.place_mm
    if places is None:
        return None
    noise = expected_noise_mm(judged.block)
    nominal, identified = (
        # Residuals are observed minus predicted: what is left is where the model puts the nests.
        relative_statistics(places - residual, places, noise)
        for residual in (judged.nominal_mm, judged.identified_mm)
    )
    return None if nominal is None or identified is None else NominalAndIdentified(nominal, identified)


def relative_statistics(wanted_mm: FloatArray, places_mm: FloatArray, noise_mm: float) -> Statistics | None:
    """Return what is left of the errors of n places after the best rigid alignment.

    Parameters
    ----------
    wanted_mm, places_mm : ndarray, shape (n, 3)
        Where they should be, and where they were read [mm].
    noise_mm : float
        Mean norm that stated noise alone gives.

    Returns
    -------
    Statistics or None
        None of fewer than four places, or of places on a line: any errors would be aligned away.
    """
    if len(places_mm) < _FEWEST or _on_a_line(places_mm):
        return None
    return statistics(aligned_errors(wanted_mm, places_mm), noise_mm)


def aligned_errors(wanted_mm: FloatArray, places_mm: FloatArray) -> FloatArray:
    """Return what the best rigid alignment leaves of errors.

    Parameters
    ----------
    wanted_mm, places_mm : ndarray, shape (n, 3)
        Where they should be, and where they were read; n >= 3.

    Returns
    -------
    ndarray, shape (n, 3)
        Read minus wanted [mm].
    """
    rotation, translation = rigid_alignment(wanted_mm, places_mm)
    return np.asarray(places_mm - (wanted_mm @ rotation.T + translation))


def rigid_motions(places_mm: FloatArray) -> FloatArray:
    """Return how places move with shifts and small turns about their middle.

    Parameters
    ----------
    places_mm : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (3 n, 6)
        Three shifts, then three turns over the largest coordinate about the middle, so that all columns are
        of one size [1].
    """
    arms = places_mm - places_mm.mean(axis=0)
    turns = np.cross(np.eye(3)[:, None], arms) / max(float(np.abs(arms).max()), 1.0)
    shifts = np.broadcast_to(np.eye(3)[:, None], turns.shape)
    return np.concatenate([shifts, turns]).reshape(6, -1).T


def _on_a_line(places_mm: FloatArray) -> bool:
    widths = np.linalg.svd(places_mm - places_mm.mean(axis=0), compute_uv=False)
    # About a line that thin a rotation is told by the errors alone.
    return bool(widths[1] < 1e-3 * max(widths[0], 1e-12))


_OF_THE_TOOL = "tool_rx"


def turn_errors(model: Model, readings: Readings | None) -> TurnPair | None:
    """Return the angles between measured orientations and those of a model.

    Parameters
    ----------
    model : Model
    readings : PointReadings, LegReadings or ContactReadings, optional

    Returns
    -------
    TurnPair or None
        [rad]; None where no orientation was read, and of a model that was made without: it does not know how
        the frame of the readings is turned against the last one.
    """
    if not isinstance(readings, PointReadings) or _OF_THE_TOOL not in {p.name for p in model.parameters}:
        return None
    from truepose.identification.observations.poses import orientation_block  # few read them

    block = orientation_block(readings)
    if block is None:
        return None
    # The nominal robot with the tool as it was fitted around it, too: otherwise its angle would be the
    # tool's.
    nominal, identified = (_turns(block, one(model)) for one in (nominal_estimate, identified_estimate))
    return TurnPair(nominal, identified)


def _turns(block: "OrientationBlock", model: Estimate) -> TurnStatistics:
    angles: FloatArray = np.linalg.norm(block.result(model.structure, model.values, None).residual, axis=1)
    return TurnStatistics(
        n=len(angles),
        mean_rad=float(angles.mean()),
        rms_rad=float(np.sqrt((angles**2).mean())),
        sd_rad=float(angles.std(ddof=1)) if len(angles) > 1 else 0.0,
        max_rad=float(angles.max()),
        # Where readings state nothing, nothing was to be expected of them.
        noise_rad=mean_norm(block.covariance()) if block.stated_sigma() > 0.0 else math.nan,
    )


_FEWEST_POINTS = 3  # points, not on a line, that place a frame


def judged_by_positions(
    campaign: Campaign, model: Model, cups: tuple[Anchor, ...] | None = None
) -> PositionsJudged | None:
    """Judge a model of lengths on the positions of its campaign.

    Parameters
    ----------
    campaign : Campaign
        `validation` holds the positions, `cups` where the base cups are in their frame.
    model : Model
    cups : tuple of Anchor, optional
        The base cups in the frame of the model; by default the model's own.

    Returns
    -------
    PositionsJudged or None
        [mm]; None of fewer than three positions. Tied figures are None with fewer than three cups.
    """
    points = campaign.validation
    if points is None or len(points) < _FEWEST_POINTS:
        return None
    found = judge(model, points, model.repeatability_mm)
    nominal, identified = found.nominal.state.position_mm, found.position_mm
    noise = expected_noise_mm(found.block)

    def pair(first: FloatArray, second: FloatArray) -> NominalAndIdentified:
        return NominalAndIdentified(
            statistics(points.position_mm - first, noise), statistics(points.position_mm - second, noise)
        )

    # Each model by its own best motion: aligned by that of the other, it would carry the other's errors.
    aligned = pair(*(_aligned(places, places, points.position_mm) for places in (nominal, identified)))
    # Each model is tied by the cups as it has them itself.
    before = _matched(cups or model.nominal_anchors, campaign.cups)
    after = _matched(cups or identified_anchors(model), campaign.cups)
    # Both tied or none: figures of one frame are not compared with those of another.
    if before is None or after is None:
        return PositionsJudged(None, aligned)
    return PositionsJudged(pair(_aligned(nominal, *before), _aligned(identified, *after)), aligned)


def _matched(anchors: tuple[Anchor, ...], cups: CupReadings | None) -> tuple[FloatArray, FloatArray] | None:
    """Return the cups as the model has them and as they were measured, shape (n, 3) each."""
    if cups is None:
        return None
    places = {(anchor.placement, anchor.base_point): anchor.centre_mm for anchor in anchors}
    pairs = list(zip(cups.placement.tolist(), cups.base_point.tolist(), strict=True))
    # The tracker may have measured cups that no leg was read from.
    rows = [row for row, pair in enumerate(pairs) if pair in places]
    if len(rows) < _FEWEST_POINTS:
        return None
    return np.array([places[pairs[row]] for row in rows]), cups.position_mm[rows]


def _aligned(points_mm: FloatArray, moving_mm: FloatArray, fixed_mm: FloatArray) -> FloatArray:
    """Return the points moved as `moving_mm` must be to lie on `fixed_mm`."""
    rotation, translation = rigid_alignment(moving_mm, fixed_mm)
    return np.asarray(points_mm @ rotation.T + translation)
