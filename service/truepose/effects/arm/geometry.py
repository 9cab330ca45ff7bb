"""Errors of the links: DH-Modified with joint offsets, and the rotation that near-parallel axes need.

    RotX(alpha_i + d alpha_i) TransX(a_i + d a_i) RotY(d beta_i) RotZ(theta_i + d theta_i) TransZ(d_i + d d_i)

Row 1 has no error parameters: they belong to the base. Where axes i-1 and i are (nearly) parallel,
d_i acts as d_(i-1) does and is no parameter, and a rotation about y (Hayati's beta) enters instead:
a common normal of parallel axes may lie anywhere, so DH-Modified alone cannot express that tilt.
Found from the nominal table, never from a robot's name.

The thesis drops one of d_2, d_3 and adds nothing (30 parameters). Links tilted by 0.02 deg then leave
0.03 to 0.05 mm on average, with beta 0.011 mm.

References
----------
A. Nubiola, PhD thesis, ETS Montreal, 2014, section 2.3.
S. A. Hayati, Proc. 22nd IEEE Conf. Decision and Control, 1983, 1477-1483.
"""

from functools import cache

import numpy as np

from truepose.domain.identification import NotIdentifiable
from truepose.domain.robot import Robot
from truepose.effects.names import joint_name, joint_of
from truepose.effects.ports import NOTHING, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import message

# Three to four times the largest errors of the thesis' IRB 120 (table 2.6: 0.25 mm, 0.09 deg). Where data ask
# for more, all widths of the geometry are widened together (identification.fit.robust).
LENGTH_WIDTH_MM = 1.0
ANGLE_WIDTH_RAD = 5e-3
# Below this angle the common normal moves by more than 30 mm per mm of axis offset: treated as parallel.
_PARALLEL_RAD = np.deg2rad(2.0)

_KINDS = {
    "alpha": PortKind.ALPHA,
    "a": PortKind.A,
    "beta": PortKind.BETA,
    "theta": PortKind.THETA,
    "d": PortKind.D,
}


def is_parallel_to_previous(robot: Robot, joint: int) -> bool:
    """Say whether the axis of a joint is (nearly) parallel to the one before: within 2 deg, either way round.

    Parameters
    ----------
    robot : Robot
        Nominal.
    joint : int
        0-based; never so of the first.
    """
    return joint > 0 and abs(np.sin(robot.joints[joint].alpha_rad)) < np.sin(_PARALLEL_RAD)


def _length(quantity: str, joint: int) -> ParameterSpec:
    return ParameterSpec(joint_name(quantity, joint), "mm", 0.0, LENGTH_WIDTH_MM)


def _angle(quantity: str, joint: int) -> ParameterSpec:
    return ParameterSpec(joint_name(quantity, joint), "rad", 0.0, ANGLE_WIDTH_RAD)


class Geometry:
    """DH-Modified errors of rows 2..J; with `tilt`, also beta of near-parallel axes.

    Parameters
    ----------
    name : str
    tilt : bool
        Without it, the parameters are those of the thesis.
    """

    needs = NOTHING
    traits = frozenset({Trait.GEOMETRY, Trait.STEADY})

    def __init__(self, name: str, *, tilt: bool) -> None:
        self.name = name
        self._tilt = tilt

    def automatic(self, setting: Setting) -> bool:
        """Say that the one with beta is: it has all that the table may be wrong by."""
        return self._tilt

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return alpha, a, theta and d of every row, d replaced by beta where axes are parallel."""
        specs: list[ParameterSpec] = []
        # A change of row 1 moves the whole arm as one body, which is what the six parameters of the base do.
        for joint in range(1, setting.robot.n_joints):
            specs += [_angle("alpha", joint), _length("a", joint), _angle("theta", joint)]
            if not is_parallel_to_previous(setting.robot, joint):
                specs.append(_length("d", joint))
            elif self._tilt:
                specs.append(_angle("beta", joint))
        return tuple(specs)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the link's own quantity, one to one."""
        return list(link_terms(names))

    def left_open(self, names: tuple[str, ...], setting: Setting) -> list[NotIdentifiable]:
        """Return the offsets along parallel axes; parameters as of `LeavesOpen.left_open`."""
        # Of the model's own names: nothing is open of a table that is not identified.
        if "d_2" not in names and "alpha_2" not in names:
            return []
        return [
            NotIdentifiable(
                (f"d_{joint}", f"d_{joint + 1}"),
                message("open.parallel_axes", first=joint, second=joint + 1),
            )
            for joint in range(1, setting.robot.n_joints)
            if is_parallel_to_previous(setting.robot, joint)
        ]


class JointOffset:
    """Level 1 only: the zero of every joint except the first, which belongs to the base."""

    name = "joint_offset"
    needs = NOTHING
    traits = frozenset({Trait.GEOMETRY, Trait.ZEROS, Trait.STEADY})

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return theta of rows 2..J."""
        return tuple(_angle("theta", joint) for joint in range(1, setting.robot.n_joints))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the joint angle, one to one."""
        return list(link_terms(names))


# Asked for in every evaluation with the same names; terms do not depend on the rows.
@cache
def link_terms(names: tuple[str, ...]) -> tuple[Term, ...]:
    """Terms of parameters that are link quantities themselves, e.g. `alpha_3`: weight 1 on their own port.

    Parameters
    ----------
    names : tuple of str
    """
    return tuple(
        Term(k, Port(_KINDS[name.rsplit("_", 1)[0]], joint_of(name)), 1.0) for k, name in enumerate(names)
    )
