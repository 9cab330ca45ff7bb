"""Where the fixed nests of a measured campaign stand in the world of a model.

A model that looked at their readings states by how much each was off its certificate, `fixed_<nest>_x`..
[mm], and by which small motion about the world's origin the world was registered wrong, `frame_x`..`frame_rz`
[mm, rad]; the motion comes after the offset.
"""

import numpy as np

from truepose_simulators.physics.effects import Stated
from truepose_simulators.physics.effects.stated import COMPONENTS
from truepose_simulators.physics.identified import IdentifiedModel
from truepose_simulators.physics.rigid import FloatArray, move, placed
from truepose_simulators.recording.replaying.measured_table import MeasuredTable

_EFFECT = "reference"
_FORM = "fixed_<nest>_x, _y, _z, frame_x to frame_rz"


def places_of_fixed_nests(
    table: MeasuredTable, certified_mm: FloatArray, model: IdentifiedModel
) -> FloatArray:
    """Place of the fixed nest in every row, shape (n, 3) [mm, world], before the instrument sees it.

    Nests without a certificate, of which `certified_mm` (k, 3) has none, are where they were read on average.
    """
    nest = table.known("fixed_nest")
    read = np.stack([table.known(f"{axis}_mm") for axis in "xyz"], axis=1)
    frame, offsets = _stated(model)
    places = np.empty_like(read)
    for number in np.unique(nest):
        here = nest == number
        places[here] = read[here].mean(axis=0)
        if 1 <= number <= len(certified_mm):
            offset = offsets.get(int(number), np.zeros(3))
            places[here] = move(placed(frame[:3], frame[3:]), certified_mm[int(number) - 1] + offset)
    return places


def _stated(model: IdentifiedModel) -> tuple[FloatArray, dict[int, FloatArray]]:
    """Return the six components of the registration's error and the offset of every nest."""
    frame = np.zeros(6)
    offsets: dict[int, FloatArray] = {}
    stated = Stated(_EFFECT, model.parameters.get(_EFFECT, {}))
    pattern = r"(?:fixed_([0-9]+)_([xyz])|frame_(r?[xyz]))"
    for (nest, axis, component), value in stated.matching(pattern, _FORM):
        if nest is None:
            frame[COMPONENTS.index(component)] = value
        else:
            offsets.setdefault(int(nest), np.zeros(3))["xyz".index(axis)] = value
    return frame, offsets
