"""Anchors, attachment and length offset of legs without a starting guess.

For a given attachment, |p_n - a|^2 = (l_n - offset)^2 is linear in the anchor a and |a|^2 once two
readings are subtracted; a coarse set of attachments is tried, the best are refined robustly.

An anchor whose place is told is started there. A few legs from nests that lie close together fit nearly as
well to the anchor's image in the plane of the nests, and no refinement leads from one to the other.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.kinematics.chain import Chain

_RADII_MM = (0.0, 60.0, 150.0, 300.0)
_REFINED = 4
_SUBSET = 300  # readings used for the search; plenty for seven unknowns
_FEWEST = 12  # of one anchor; four would do without errors
_SCALE_MM = 2.0  # residuals beyond this count linearly: the size of a nominal robot's errors


@dataclass(frozen=True, slots=True)
class LegPlacement:
    """Where the nominal robot puts anchors and nests."""

    anchors_mm: FloatArray  # (A, 3)
    nests_mm: FloatArray  # (K, 3)
    offset_mm: float


def place_legs(
    chain: Chain,
    nest: IntArray,
    anchor: IntArray,
    length_mm: FloatArray,
    nests_mm: FloatArray,
    nest_unknown: BoolArray,
    told_mm: FloatArray,
    *,
    with_offset: bool,
) -> LegPlacement:
    """Find anchors, unknown nests and the offset for the nominal robot.

    Parameters
    ----------
    chain : Chain
        Nominal chain at n readings, base at the identity.
    nest, anchor : ndarray, shape (n,)
        1-based nest, 0-based anchor of each reading.
    length_mm : ndarray, shape (n,)
    nests_mm : ndarray, shape (K, 3)
    nest_unknown : ndarray, shape (K,)
    told_mm : ndarray, shape (A, 3)
        About where each anchor is, base at the identity; NaN where only its legs tell.
    with_offset : bool
        Whether a constant is added to every length.

    Returns
    -------
    LegPlacement
    """
    rows = _spread(anchor)
    search = _Search(
        chain.rotation[-1][rows], chain.origin[-1][rows], nest[rows], anchor[rows], length_mm[rows],
        nests_mm, nest_unknown, told_mm, with_offset,
    )  # fmt: skip
    starts = [search.start(attachment) for attachment in attachments(bool(nest_unknown.any()))]
    starts.sort(key=search.typical)
    ends = [search.refined(start) for start in starts[:_REFINED]]
    return search.answer(min(ends, key=search.typical))


def _spread(anchor: IntArray) -> IntArray:
    """Return rows of every anchor: an even choice of all might step over one that comes round regularly."""
    each = max(_FEWEST, _SUBSET // (int(anchor.max()) + 1))
    chosen = []
    for number in distinct_values(anchor).tolist():
        rows = np.flatnonzero(anchor == number)
        spread = np.linspace(0, len(rows) - 1, min(len(rows), each)).astype(np.int64)
        chosen.append(rows[distinct_values(spread)])
    return np.sort(np.concatenate(chosen))


def attachments(unknown: bool) -> list[FloatArray]:
    """Return the places in the last frame where an unknown nest is tried first, shape (3,) each."""
    if not unknown:
        return [np.zeros(3)]
    directions = [np.array(d, dtype=float) for d in np.ndindex(3, 3, 3)]
    unit = [(d - 1) / np.linalg.norm(d - 1) for d in directions if np.any(d != 1)]
    return [np.zeros(3)] + [radius * d for radius in _RADII_MM[1:] for d in unit]


@dataclass(frozen=True, slots=True)
class _Search:
    rotation: FloatArray
    origin: FloatArray
    nest: IntArray
    anchor: IntArray
    length: FloatArray
    nests: FloatArray
    unknown: BoolArray
    told: FloatArray
    with_offset: bool

    def start(self, attachment: FloatArray) -> FloatArray:
        nests = np.where(self.unknown[:, None], attachment, self.nests)
        points = self._points(nests)
        known = ~np.isnan(self.told[:, 0])
        anchors = [place if known[k] else self._trilaterate(points, k) for k, place in enumerate(self.told)]
        return np.concatenate([
            np.ravel(anchors),
            nests[self.unknown].ravel(),
            np.zeros(int(self.with_offset)),
        ])

    def _points(self, nests: FloatArray) -> FloatArray:
        points: FloatArray = self.origin + np.einsum("nij,nj->ni", self.rotation, nests[self.nest - 1])
        return points

    def _trilaterate(self, points: FloatArray, anchor: int) -> FloatArray:
        here = self.anchor == anchor
        p, length = points[here], self.length[here]
        design = np.column_stack([-2.0 * p, np.ones(len(p))])
        right = length**2 - (p**2).sum(axis=1)
        return np.asarray(np.linalg.lstsq(design, right, rcond=1e-9)[0][:3])

    def residual(self, unknowns: FloatArray) -> FloatArray:
        answer = self.answer(unknowns)
        arms = self._points(answer.nests_mm) - answer.anchors_mm[self.anchor]
        return np.asarray(self.length - np.linalg.norm(arms, axis=1) - answer.offset_mm)

    def typical(self, unknowns: FloatArray) -> float:
        return float(np.median(np.abs(self.residual(unknowns))))

    def refined(self, start: FloatArray) -> FloatArray:
        from scipy.optimize import least_squares  # its import takes longer than a campaign of points needs

        end = least_squares(
            self.residual, start, loss="soft_l1", f_scale=_SCALE_MM, max_nfev=100, x_scale=10.0
        )
        return np.asarray(end.x)

    def answer(self, unknowns: FloatArray) -> LegPlacement:
        split = self.told.size
        nests = self.nests.copy()
        n_free = 3 * int(self.unknown.sum())
        nests[self.unknown] = unknowns[split : split + n_free].reshape(-1, 3)
        offset = float(unknowns[-1]) if self.with_offset else 0.0
        return LegPlacement(unknowns[:split].reshape(-1, 3), nests, offset)
