"""Targets of contacts: parameters that no effect brings, in the order of the structure's targets."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.targets import Target
from truepose.identification.model.parameters.anchors import LEG_OWNER
from truepose.identification.model.parameters.structure import Structure

TARGET_OWNER = "targets"  # stands for these parameters where others name their effect
COUNTERPARTS = frozenset({LEG_OWNER, TARGET_OWNER})  # of what lengths are read against


def target_prefix(target: Target) -> str:
    """Return what the names of a target's parameters begin with, e.g. `target_2_`."""
    return f"target_{target.number}_"


def indices_of_target(structure: Structure, target: Target) -> slice:
    """Return where the parameters of a target stand, which follow one another."""
    prefix = target_prefix(target)
    found = [k for k in structure.indices_of(TARGET_OWNER) if structure.names[k].startswith(prefix)]
    return slice(found[0], found[-1] + 1)


def certified_zeros(structure: Structure) -> frozenset[str]:
    """Return the names of the parameters that only stand for the uncertainty of a certificate."""
    return frozenset(
        f"{target_prefix(target)}zero" for target in structure.targets if target.zero_mm is not None
    )


def centre_of(structure: Structure, values: FloatArray, target: Target) -> FloatArray:
    """Return the centre of a target that has one, shape (3,) [mm, world frame]."""
    return np.asarray(values[indices_of_target(structure, target)][:3])
