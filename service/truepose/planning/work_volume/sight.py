"""Whether the tracker sees a reflector: within its cone, and nothing between them.

In the way may be the arm, as capsules, and keep-out volumes; one in which the tracker itself stands is no
solid thing and hides nothing. The last link carries the nests: what it hides is said by where they face.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.kinematics.chain import Chain
from truepose.planning.ballbar.clear_ways.bodies import arm_body, arm_links
from truepose.planning.ballbar.clear_ways.capsules import Capsules, smallest_gap
from truepose.planning.work_volume.cell_bodies import bodies_in
from truepose.planning.work_volume.keep_outs import gaps_mm, signed_mm
from truepose.planning.work_volume.work_space import (
    WorkSpace,
    cosines_to_tracker,
    nest_places,
)

_BEAM_RADIUS_MM: Final = 5.0


def cosines_in_sight(space: WorkSpace, chain: Chain, among: BoolArray | None = None) -> FloatArray:
    """Return the cosines between where each nest's reflector faces and the tracker, shape (K, n).

    -inf where something stands between them; looked at is what the tracker would see but for that, at all
    configurations or `among` some (n,).
    """
    cosines = cosines_to_tracker(space, chain)
    if space.tracker_position_mm is None:
        return cosines
    looked_at = is_seen(space, cosines) if among is None else is_seen(space, cosines) & among
    nest, row = np.nonzero(looked_at)
    hidden = _is_hidden(space, chain, nest, row, np.array(space.tracker_position_mm))
    cosines[nest[hidden], row[hidden]] = -np.inf
    return cosines


def is_seen(space: WorkSpace, cosines: FloatArray) -> BoolArray:
    """Whether reflectors with these cosines return the beam."""
    seen: BoolArray = cosines >= np.cos(space.seen_within_rad)
    return seen


def _is_hidden(
    space: WorkSpace, chain: Chain, nest: IntArray, row: IntArray, tracker_mm: FloatArray
) -> BoolArray:
    """Whether something stands before some nests (0-based) at some configurations, m of each."""
    start = nest_places(space, chain)[nest, row][None]
    beam = Capsules(start, np.broadcast_to(tracker_mm, start.shape), np.full(1, _BEAM_RADIUS_MM))
    hidden: BoolArray = np.zeros(len(row), dtype=bool)
    for volume in space.keep_outs:
        if signed_mm(volume, tracker_mm) > 0.0:
            hidden |= gaps_mm(volume, beam)[0] < 0.0
    hidden |= smallest_gap(_before_the_flange(space, chain).at(row), beam) < 0.0
    return hidden


def _before_the_flange(space: WorkSpace, chain: Chain) -> Capsules:
    arm = bodies_in(space).arm
    links = arm_links(arm)
    return arm_body(arm, chain).some([k for k, link in enumerate(links) if link < max(links)])
