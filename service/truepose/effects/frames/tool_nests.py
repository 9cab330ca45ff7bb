"""The tool as far as it is unknown: nests in the flange frame, and its orientation where poses are measured.

    x_nest = x_start + (x, y, z),    R_tool = RotX(rx) RotY(ry) RotZ(rz) R_start

The start is found from the data, or certified.
"""

from truepose.effects.names import nest_name, nest_port_index
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait

NAME = "tool"
# About the start that was found from the data; see `base`.
_NEST_WIDTH_MM = 10.0
_WIDTH_RAD = 0.05
_ROTATIONS = ("tool_rx", "tool_ry", "tool_rz")


class Tool:
    """Unknown nests and the unknown orientation of the tool; certified nests are not parameters."""

    name = NAME
    needs: frozenset[Need] = NOTHING
    traits = frozenset({Trait.PLACING, Trait.STEADY})

    def automatic(self, setting: Setting) -> bool:
        """As far as it is unknown."""
        return bool(setting.unknown_nests) or setting.has_orientations

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return three coordinates per unknown nest, three rotations where orientations were measured."""
        specs = [
            ParameterSpec(nest_name(nest, component), "mm", 0.0, _NEST_WIDTH_MM)
            for nest in setting.unknown_nests
            for component in range(3)
        ]
        if setting.has_orientations:
            # As a parameter within its certificate and not held at it: held, the error of the artefact's
            # definition goes into the arm. (irb120-camera, 36 poses, 20 seeds: a true mean error of 0.038 mm
            # with it as a parameter.)
            width = setting.tool_rotation_u_rad or _WIDTH_RAD
            specs += [ParameterSpec(name, "rad", 0.0, width) for name in _ROTATIONS]
        return tuple(specs)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the nest's coordinate or the tool's rotation, one to one."""
        return [Term(k, _port(name), 1.0) for k, name in enumerate(names)]


def _port(name: str) -> Port:
    if name in _ROTATIONS:
        return Port(PortKind.TOOL_ROTATION, _ROTATIONS.index(name))
    return Port(PortKind.NEST, nest_port_index(name))
