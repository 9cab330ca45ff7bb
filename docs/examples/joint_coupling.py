"""Coupling: a wrist joint turns a little when another joint turns, as bevel gears in a forearm do.

In the service this is one file of `service/effects` and one line in its `registry`.
"""

from itertools import pairwise

from service.effects.names import joint_of
from service.effects.ports import ParameterSpec, Port, PortKind, Rows, Setting, Term

NAME = "joint_coupling"
_WIDTH = 1e-3  # rad per rad; a gear train that couples more is described in the nominal model
_FIRST_WRIST_JOINT = 3  # 0-based: the joint that moves the others


class JointCoupling:
    """One factor for each pair of neighbouring wrist joints."""

    name = NAME

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return `coupling_4_5`: joint 5 turns by that factor with joint 4, and so on."""
        wrist = range(_FIRST_WRIST_JOINT, setting.robot.n_joints)
        return tuple(
            ParameterSpec(f"coupling_{moving + 1}_{moved + 1}", "1", 0.0, _WIDTH)
            for moving, moved in pairwise(wrist)
        )

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn the moved joint by the factor times the moving joint's angle."""
        angle_rad = rows.stops.joints_rad
        return [
            Term(k, Port(PortKind.THETA, joint_of(name)), angle_rad[:, joint_of(name) - 1])
            for k, name in enumerate(names)
        ]
