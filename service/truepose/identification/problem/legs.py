"""Identification from legs: lengths to base nests whose places are parameters too, without a starting guess.

For a given attachment, with nest places p_n, an anchor a and lengths l_n,

    |p_n - a|^2 = (l_n - offset)^2        or, with offset 0,        -2 p_n . a + |a|^2 = l_n^2 - |p_n|^2

which is linear in a and |a|^2, taken as unknowns of their own; a coarse set of attachments is tried, the best
are refined robustly, the offset with them.

An anchor whose place is told is started there. A few legs from nests that lie close together fit nearly as
well to the anchor's image in the plane of the nests, and no refinement leads from one to the other.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, LegReadings
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement
from truepose.effects.frames.base_frame import NAME as BASE
from truepose.effects.ports import ParameterSpec, Setting
from truepose.identification.model.structure import LEG_OFFSET, LEG_OWNER, Structure, anchor_name
from truepose.identification.observations.blocks import ObservationBlock
from truepose.identification.observations.fixture import BALL_NEST, clamp_block, side_block
from truepose.identification.observations.legs import leg_block
from truepose.identification.problem.initial_frames import Placement, PriorPlacement
from truepose.identification.problem.problem_setup import (
    known_placement,
    started_structure,
    with_certified_nests,
)
from truepose.kinematics.chain import Chain, nominal_chain
from truepose.kinematics.frames import placement_rotation, placement_translation

_RADII_MM = (0.0, 60.0, 150.0, 300.0)
_REFINED = 4
_SUBSET = 300  # readings used for the search; plenty for seven unknowns
_FEWEST = 12  # of one anchor; four would do without errors
_SCALE_MM = 2.0  # residuals beyond this count linearly: the size of a nominal robot's errors


@dataclass(frozen=True, slots=True)
class LegPlacement:
    """Where the nominal robot puts anchors and nests.

    Attributes
    ----------
    anchors_mm : ndarray, shape (A, 3)
        Base at the identity.
    nests_mm : ndarray, shape (K, 3)
        Flange frame.
    offset_mm : float
        Added to every length.
    """

    anchors_mm: FloatArray
    nests_mm: FloatArray
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
    """Return the places in the flange frame where an unknown nest is tried first.

    Parameters
    ----------
    unknown : bool
        Whether there is one.

    Returns
    -------
    list of ndarray, shape (3,)
        [mm]: the origin; where there is one, also on three spheres the 26 directions to faces, edges and
        corners of a cube.
    """
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
        # A cup that was clamped is started there: a handful of legs would place it badly or at its mirror
        # image.
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
        # A median: lengths of confused pairs must not decide where the search ends.
        return float(np.median(np.abs(self.residual(unknowns))))

    def refined(self, start: FloatArray) -> FloatArray:
        from scipy.optimize import least_squares  # its import takes longer than a campaign of points needs

        # Far readings count linearly: a nominal robot is off by millimetres, a confused pair by far more.
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


_ANCHOR_WIDTH_MM = 10.0  # about the start found from the data, as for an unknown base


def leg_anchors(legs: LegReadings) -> tuple[tuple[tuple[int, int], ...], IntArray]:
    """Return the cups that legs are from.

    Parameters
    ----------
    legs : LegReadings
        n of them.

    Returns
    -------
    anchors : tuple of (placement, base point)
        Distinct, in order.
    index : ndarray of int, shape (n,)
        Of each reading's anchor among them.
    """
    distinct = sorted(set(legs.cups))
    return tuple(distinct), np.array([distinct.index(cup) for cup in legs.cups])


def leg_structure(
    campaign: Campaign, legs: LegReadings, effects: tuple[str, ...], setting: Setting
) -> tuple[Structure, tuple[ObservationBlock, ...], FloatArray]:
    """Place anchors and unknown nests, and return structure, observations and start values.

    The legs come first; sides of triangles and clamped cups follow as far as the campaign has them.

    Parameters
    ----------
    campaign : Campaign
    legs : LegReadings
        Of the campaign.
    effects : tuple of str
    setting : Setting
        Of campaign and stops.

    Returns
    -------
    structure : Structure
    blocks : tuple of Block
    start : ndarray, shape (P,)
        Internal units.

    Raises
    ------
    ConfigurationError
        The base is to be identified, which legs between unknown base points do not see.
    """
    if BASE in effects:
        raise ConfigurationError(
            "Ballbar lengths from unknown base points cannot determine the base position. Leave `base` out "
            "of the effects."
        )
    anchors, index = leg_anchors(legs)
    known = known_placement(campaign)
    # A ballbar is set on its calibrator; a draw wire reads from a zero that nobody states.
    with_offset = campaign.ballbar_nominal_mm is None
    found = place_legs(
        nominal_chain(campaign.robot, legs.stops.joints_rad),
        legs.nest,
        index,
        legs.length_mm,
        known.nests_mm,
        known.nest_unknown,
        _clamped(campaign, anchors, known),
        with_offset=with_offset,
    )
    # The search was made with the base at the identity; what it found is carried to where the base stands.
    placement = _at_base(campaign.base_nominal or FramePlacement(), found)
    structure, start = started_structure(_with_base(campaign), effects, placement, np.eye(3), setting)
    structure, start = with_certified_nests(structure, start, campaign, legs.nest)
    anchors_mm = found.anchors_mm @ placement.rotation.T + placement.origin_mm
    offset_mm = found.offset_mm if with_offset else None
    structure, start = _with_anchors(structure, start, anchors, anchors_mm, offset_mm)
    return (
        structure,
        (leg_block(legs, campaign.scatter_mm, anchors), *_fixture_blocks(campaign, anchors)),
        start,
    )


def _clamped(campaign: Campaign, anchors: tuple[tuple[int, int], ...], known: PriorPlacement) -> FloatArray:
    """Return where the nominal arm, base at the identity, held each anchor's ball; NaN where none."""
    places = np.full((len(anchors), 3), np.nan)
    setup, nest = campaign.setup, BALL_NEST - 1
    # Where the ball was is known only as well as the nest that held it.
    if setup is None or known.nest_unknown[nest]:
        return places
    held = nominal_chain(campaign.robot, setup.joints_rad).points(known.nests_mm[nest])
    clamped = zip(setup.placement.tolist(), setup.base_point.tolist(), strict=True)
    for row, pair in enumerate(clamped):
        if pair in anchors:
            places[anchors.index(pair)] = held[row]
    return places


def _fixture_blocks(campaign: Campaign, anchors: tuple[tuple[int, int], ...]) -> list[ObservationBlock]:
    """Return what ties the anchors to each other and to the robot, as far as the campaign has it."""
    fixture, setup, clamped_mm = campaign.fixture, campaign.setup, campaign.setup_uncertainty_mm
    blocks: list[ObservationBlock | None] = []
    if fixture is not None:
        blocks.append(side_block(fixture, anchors, len(campaign.nests), campaign.robot))
    if setup is not None and clamped_mm is not None:
        # The arm stood where it came to stand, not where it was sent: its scatter is in the cup's place.
        off_mm = float(np.hypot(clamped_mm, campaign.robot.repeatability_mm))
        blocks.append(clamp_block(setup, anchors, off_mm))
    return [block for block in blocks if block is not None]


def _at_base(base: FramePlacement, found: LegPlacement) -> Placement:
    """Return the nominal base, held, with the nests found."""
    return Placement(
        rotation=placement_rotation(base),
        origin_mm=placement_translation(base),
        nests_mm=found.nests_mm,
        residual_mm=np.zeros((0, 3)),
        weights=np.zeros(0),
    )


def _with_base(campaign: Campaign) -> Campaign:
    """Return the campaign with the world at the nominal base: legs alone cannot tell them apart."""
    # It then counts as stated, and its prior is not about something that was found.
    if campaign.base_nominal is not None:
        return campaign
    return replace(campaign, base_nominal=FramePlacement())


def _with_anchors(
    structure: Structure,
    start: FloatArray,
    anchors: tuple[tuple[int, int], ...],
    places_mm: FloatArray,
    offset_mm: float | None,
) -> tuple[Structure, FloatArray]:
    names = [anchor_name(anchor, component) for anchor in anchors for component in range(3)]
    values = places_mm.ravel().tolist()
    if offset_mm is not None:
        names.append(LEG_OFFSET)
        values.append(offset_mm)
    extra = tuple(
        ParameterSpec(name, "mm", value, _ANCHOR_WIDTH_MM) for name, value in zip(names, values, strict=True)
    )
    widened = replace(
        structure,
        specs=structure.specs + extra,
        owners=structure.owners + (LEG_OWNER,) * len(extra),
        anchors=anchors,
    )
    return widened, np.concatenate([start, values])
