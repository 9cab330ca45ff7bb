"""Where the robot stands: six parameters of its base in the world.

    o = o_start + (x, y, z),    R = RotX(rx) RotY(ry) RotZ(rz) R_start

Level 2 with an absolute calibration (thesis of A. Nubiola, 2014, section 1.1): row 1 of the table is part of
it.
"""

from truepose.domain.identification import NotIdentifiable
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import message

NAME = "base"
PARAMETERS = ("base_x", "base_y", "base_z", "base_rx", "base_ry", "base_rz")

# About the start, which is the drawing's or was found from the data: wide enough to pull on nothing
# that the data determine, narrow enough to hold what they do not.
WIDTH_MM = 10.0
WIDTH_RAD = 0.05


class Base:
    """Base frame: translation in the world, and rotation RotX RotY RotZ before the start rotation."""

    name = NAME
    needs: frozenset[Need] = NOTHING
    traits = frozenset({Trait.PLACING, Trait.STEADY})

    def automatic(self, setting: Setting) -> bool:
        """Positions say where the robot stands; lengths do not."""
        return not setting.lengths

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the six parameters."""
        translation = (ParameterSpec(name, "mm", 0.0, WIDTH_MM) for name in PARAMETERS[:3])
        rotation = (ParameterSpec(name, "rad", 0.0, WIDTH_RAD) for name in PARAMETERS[3:])
        return (*translation, *rotation)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the base port, one to one."""
        return [Term(k, Port(PortKind.BASE, PARAMETERS.index(name)), 1.0) for k, name in enumerate(names)]

    def left_open(self, names: tuple[str, ...], setting: Setting) -> list[NotIdentifiable]:
        """Return row 1 of the table beside the base; parameters as of `LeavesOpen.left_open`."""
        of_table = ("d_", "theta_", "alpha_")
        if "base_z" not in names or not any(name.startswith(of_table) for name in names):
            return []
        reason = message("open.row_1")
        return [NotIdentifiable(("d_1", "theta_1", "base_z", "base_rz"), reason)]
