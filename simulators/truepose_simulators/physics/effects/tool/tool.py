"""Where an identified model says that the nests of the tool are."""

from truepose_simulators.physics.effects.stated import Stated
from truepose_simulators.physics.rigid import FloatArray


def placed_nests(start_mm: FloatArray, stated: Stated) -> FloatArray:
    """Nests in the last frame, shape (m, 3), from their start and `nest_<nest>_x`.. [mm].

    `tool_rx`.. say how a measured orientation lies in the last frame; they move no nest.
    """
    nests = start_mm.copy()
    form = "nest_<nest>_x, _y, _z, tool_rx, _ry, _rz"
    for (nest, axis), value in stated.matching(r"(?:nest_([0-9]+)_([xyz])|tool_r[xyz])", form):
        if nest is not None:
            nests[stated.index(nest, len(nests), "nest"), "xyz".index(axis)] += value
    return nests
