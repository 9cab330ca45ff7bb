"""Base nests of legs, the anchors, and the offset of the length: parameters that no effect brings."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.identification.model.parameters.structure import Structure

LEG_OWNER = "legs"  # stands for these parameters where others name their effect
LEG_OFFSET = "length_offset"


def anchor_name(anchor: tuple[int, int], component: int) -> str:
    """Return e.g. `anchor_1_3_x` for placement 1, base point 3, component 0."""
    return f"anchor_{anchor[0]}_{anchor[1]}_{'xyz'[component]}"


def first_anchor(structure: Structure) -> int:
    """Return the index of the first coordinate of the base cups, which follow one another."""
    return structure.index_of(anchor_name(structure.anchors[0], 0))


def anchor_places(structure: Structure, values: FloatArray) -> FloatArray:
    """Return the places of the base cups at these values, shape (A, 3) [mm]."""
    first = first_anchor(structure)
    return np.asarray(values[first : first + 3 * len(structure.anchors)].reshape(-1, 3))
