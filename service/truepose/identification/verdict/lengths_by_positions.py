"""Positions as a judge of a model of lengths, whose frame lengths alone leave open.

Two answers: tied to the world by the cups that a tracker measured there, and after the best rigid alignment.
Neither the cups nor the positions have a part in the identification.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Campaign, CupReadings
from truepose.domain.results.identification import Anchor, Model, NominalAndIdentified, PositionsJudged
from truepose.identification.model.estimates import identified_anchors
from truepose.identification.verdict.judge import judge
from truepose.identification.verdict.statistics import expected_noise_mm, statistics
from truepose.kinematics.frames import rigid_alignment

_FEWEST = 3  # points, not on a line, that place a frame


def judged_by_positions(
    campaign: Campaign, model: Model, cups: tuple[Anchor, ...] | None = None
) -> PositionsJudged | None:
    """Judge a model of lengths on the positions of its campaign; None where there are too few.

    Parameters
    ----------
    campaign : Campaign
        `validation` holds the positions, `cups` where the base cups are in their frame.
    model : Model
    cups : tuple of Anchor, optional
        The base cups in the frame of the model; by default the model's own.
    """
    points = campaign.validation
    if points is None or len(points) < _FEWEST:
        return None
    found = judge(model, points, model.repeatability_mm)
    nominal, identified = found.nominal.state.position_mm, found.position_mm
    noise = expected_noise_mm(found.block)

    def pair(first: FloatArray, second: FloatArray) -> NominalAndIdentified:
        return NominalAndIdentified(
            statistics(points.position_mm - first, noise), statistics(points.position_mm - second, noise)
        )

    aligned = pair(*(_aligned(places, places, points.position_mm) for places in (nominal, identified)))
    before = _matched(cups or model.nominal_anchors, campaign.cups)
    after = _matched(cups or identified_anchors(model), campaign.cups)
    if before is None or after is None:
        return PositionsJudged(None, aligned)
    return PositionsJudged(pair(_aligned(nominal, *before), _aligned(identified, *after)), aligned)


def _matched(anchors: tuple[Anchor, ...], cups: CupReadings | None) -> tuple[FloatArray, FloatArray] | None:
    """Return the cups as the model has them and as they were measured, shape (n, 3) each."""
    if cups is None:
        return None
    places = {(anchor.placement, anchor.base_point): anchor.centre_mm for anchor in anchors}
    pairs = list(zip(cups.placement.tolist(), cups.base_point.tolist(), strict=True))
    rows = [row for row, pair in enumerate(pairs) if pair in places]
    if len(rows) < _FEWEST:
        return None
    return np.array([places[pairs[row]] for row in rows]), cups.position_mm[rows]


def _aligned(points_mm: FloatArray, moving_mm: FloatArray, fixed_mm: FloatArray) -> FloatArray:
    """Return the points moved as `moving_mm` must be to lie on `fixed_mm`."""
    rotation, translation = rigid_alignment(moving_mm, fixed_mm)
    return np.asarray(points_mm @ rotation.T + translation)
