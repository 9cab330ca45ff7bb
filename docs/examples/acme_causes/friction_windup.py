"""Friction windup: a gear rubs the more, the more it carries, so that its joint stops short of its target.

The angle is off by -friction x |torque| against the direction of the joint's last motion: backlash that grows
with the load. A package brings it as `BROUGHT`; inside the service it would be a line of the registry.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.causes import OF_SUBJECT, Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.names import joint_name, joint_of, joint_subject
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term

NAME = "friction_windup"
_WIDTH = 3e-8  # rad/(N mm): what 10 N m of load would then leave, 0.02 deg, is more than most gears show
_LOADED_N_MM = 500.0  # less load does not let a gear rub more than it does by itself


class FrictionWindup:
    """One friction per joint that carries load."""

    name = NAME
    needs: frozenset[Need] = frozenset({"torque", "direction"})  # what a row must tell
    signature = Signature(OF_SUBJECT, "torque of {subject}", "sign")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return `friction_2` and so on for the joints that carry load."""
        return tuple(_spec(joint) for joint in _loaded(setting))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn each joint back by its friction times its load; nothing where a row does not tell."""
        joints = [joint_of(name) for name in names]
        return [
            Term(k, Port(PortKind.THETA, joint), _short_of(rows, joint)) for k, joint in enumerate(joints)
        ]

    def unseen(self, scene: Scene) -> str | None:
        """Need loads, and stops approached from both sides."""
        if scene.torque_n_mm is None or not _loaded(scene.setting):
            return "no joint is known to carry load: give the masses of links and tool"
        if scene.stops.direction is None or np.ptp(np.sign(scene.stops.direction), axis=0).max() < 2:
            return "every joint came from one side only: approach half of the configurations from the other"
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each loaded joint whose friction the model lacks."""
        if self.unseen(scene) is not None:
            return ()
        joints = [
            joint for joint in _loaded(scene.setting) if joint_name("friction", joint) not in scene.present
        ]
        return tuple(Candidate(NAME, joint_subject(joint), (_spec(joint),)) for joint in joints)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how far the load keeps the joint from where it is sent."""
        friction, uncertainty = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        sentence = f"The gear of {subject} rubs under load: its joint stops short of where it is sent."
        return Description(subject, friction, "rad/(N*mm)", uncertainty, sentence)


def _spec(joint: int) -> ParameterSpec:
    return ParameterSpec(joint_name("friction", joint), "rad/(N*mm)", 0.0, _WIDTH)


def _loaded(setting: Setting) -> list[int]:
    joints: list[int] = np.flatnonzero(setting.largest_torque_n_mm > _LOADED_N_MM).tolist()
    return joints


def _short_of(rows: Rows, joint: int) -> FloatArray:
    if rows.torque_n_mm is None or rows.stops.direction is None:
        return np.zeros(len(rows.stops))
    load = np.nan_to_num(np.abs(rows.torque_n_mm[:, joint]), nan=0.0)
    # The direction is that of the angle as the controller counts it, the port that of the axis.
    against: FloatArray = -rows.robot.joints[joint].sign * np.sign(rows.stops.direction[:, joint]) * load
    return against


BROUGHT = FrictionWindup()
