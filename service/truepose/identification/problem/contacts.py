"""Identification from closed loops: readings against targets whose places are parameters too."""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray, distinct_values
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Campaign, ContactReadings
from truepose.domain.measurement.targets import Target
from truepose.domain.robot import FramePlacement
from truepose.effects.base.base_frame import NAME as BASE
from truepose.effects.ports import Setting
from truepose.identification.model.parameters.counterparts import TARGET_OWNER, target_prefix
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import Block
from truepose.identification.observations.contacts.block import contact_block
from truepose.identification.observations.contacts.distances import distance_block
from truepose.identification.observations.contacts.kinds import KINDS
from truepose.identification.problem.certified_nests import with_certified_nests
from truepose.identification.problem.contact_placement import (
    ContactPlacement,
    Contacts,
    place_contacts,
    spread_over_targets,
)
from truepose.identification.problem.placement import Placement
from truepose.identification.problem.setting import known_placement
from truepose.identification.problem.start import started_structure
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation


def contact_structure(
    campaign: Campaign, contacts: ContactReadings, effects: tuple[str, ...], setting: Setting
) -> tuple[Structure, tuple[Block, ...], FloatArray]:
    """Place targets and unknown nests, and return structure, observations and start values, shape (P,).

    The contacts come first; certified distances follow where the campaign has them.

    Raises
    ------
    ConfigurationError
        The base is to be identified, which contacts with targets of unknown place do not see.
    """
    if BASE in effects:
        raise ConfigurationError(
            "Contacts with targets of unknown place do not see where the base stands: "
            "leave `base` out of the effects."
        )
    base = campaign.base_nominal or FramePlacement()
    campaign = replace(campaign, base_nominal=base)
    found = _placed(campaign, contacts, base)
    placement = Placement(
        placement_rotation(base),
        placement_translation(base),
        found.nests_mm,
        np.zeros((0, 3)),
        np.zeros(0),
    )
    structure, start = started_structure(campaign, effects, placement, found.tool_rotation, setting)
    structure, start = with_certified_nests(structure, start, campaign, contacts.nest)
    structure, start = _with_targets(structure, start, found)
    blocks: list[Block] = [contact_block(contacts, campaign.scatter_mm, structure.targets)]
    if campaign.target_distances is not None:
        certified = distance_block(campaign.target_distances, structure.targets, campaign.robot)
        blocks += [] if certified is None else [certified]
    return structure, tuple(blocks), start


def _placed(campaign: Campaign, contacts: ContactReadings, base: FramePlacement) -> ContactPlacement:
    touched = distinct_values(contacts.target)
    targets = tuple(target for target in campaign.targets if target.number in touched)
    index = np.searchsorted(touched, contacts.target)
    targets = tuple(sorted(targets, key=_number))
    few = spread_over_targets(index)
    nominal = nominal_values(campaign.robot, contacts.stops.joints_rad[few])
    chain = forward(nominal, placement_rotation(base), placement_translation(base))
    known = known_placement(campaign)
    return place_contacts(
        Contacts(
            rotation=chain.end_rotation,
            origin_mm=chain.end_origin,
            nest=contacts.nest[few],
            target=index[few],
            axis=contacts.axes[few],
            reading_mm=contacts.reading_mm[few],
            nests_mm=known.nests_mm,
            nest_unknown=known.nest_unknown,
            targets=targets,
        )
    )


def _number(target: Target) -> int:
    return target.number


def _with_targets(
    structure: Structure, start: FloatArray, found: ContactPlacement
) -> tuple[Structure, FloatArray]:
    specs = tuple(
        spec._replace(name=f"{target_prefix(target)}{spec.name}")
        for target, values in zip(found.targets, found.values, strict=True)
        for spec in KINDS[target.kind].parameters(target, values)
    )
    widened = replace(
        structure,
        specs=structure.specs + specs,
        owners=structure.owners + (TARGET_OWNER,) * len(specs),
        targets=found.targets,
    )
    return widened, np.concatenate([start, *found.values])
