"""Identification from legs: lengths between tool nests and base nests whose places are parameters too."""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Campaign, LegReadings
from truepose.domain.robot import FramePlacement
from truepose.effects.base.base_frame import NAME as BASE
from truepose.effects.ports import ParameterSpec, Setting
from truepose.identification.model.parameters.anchors import LEG_OFFSET, LEG_OWNER, anchor_name
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import Block
from truepose.identification.observations.fixture import BALL_NEST, clamp_block, side_block
from truepose.identification.observations.legs import leg_block
from truepose.identification.problem.certified_nests import with_certified_nests
from truepose.identification.problem.leg_placement import LegPlacement, place_legs
from truepose.identification.problem.placement import Known, Placement
from truepose.identification.problem.setting import known_placement
from truepose.identification.problem.start import started_structure
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import placement_rotation, placement_translation

_ANCHOR_WIDTH_MM = 10.0  # about the start found from the data, as for an unknown base


def leg_anchors(legs: LegReadings) -> tuple[tuple[tuple[int, int], ...], IntArray]:
    """Return the distinct (placement, base point) pairs and the index of each reading among them."""
    distinct = sorted(set(legs.cups))
    return tuple(distinct), np.array([distinct.index(cup) for cup in legs.cups])


def leg_structure(
    campaign: Campaign, legs: LegReadings, effects: tuple[str, ...], setting: Setting
) -> tuple[Structure, tuple[Block, ...], FloatArray]:
    """Place anchors and unknown nests, and return structure, observations and start values, shape (P,).

    The legs come first; sides of triangles and clamped cups follow as far as the campaign has them.

    Raises
    ------
    ConfigurationError
        The base is to be identified, which legs between unknown base points do not see.
    """
    if BASE in effects:
        raise ConfigurationError(
            "Legs between unknown base points do not see where the base stands: "
            "leave `base` out of the effects."
        )
    anchors, index = leg_anchors(legs)
    known = known_placement(campaign)
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


def _clamped(campaign: Campaign, anchors: tuple[tuple[int, int], ...], known: Known) -> FloatArray:
    """Return where the nominal arm, base at the identity, held each anchor's ball; NaN where none."""
    places = np.full((len(anchors), 3), np.nan)
    setup, nest = campaign.setup, BALL_NEST - 1
    if setup is None or known.nest_unknown[nest]:
        return places
    held = nominal_chain(campaign.robot, setup.joints_rad).points(known.nests_mm[nest])
    clamped = zip(setup.placement.tolist(), setup.base_point.tolist(), strict=True)
    for row, pair in enumerate(clamped):
        if pair in anchors:
            places[anchors.index(pair)] = held[row]
    return places


def _fixture_blocks(campaign: Campaign, anchors: tuple[tuple[int, int], ...]) -> list[Block]:
    """Return what ties the anchors to each other and to the robot, as far as the campaign has it."""
    fixture, setup, clamped_mm = campaign.fixture, campaign.setup, campaign.setup_uncertainty_mm
    blocks: list[Block | None] = []
    if fixture is not None:
        blocks.append(side_block(fixture, anchors, len(campaign.nests), campaign.robot))
    if setup is not None and clamped_mm is not None:
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
