"""Joint gain: a joint turns by a factor 1 + k of what it should (level 1 with an offset)."""

from service.effects.names import joint_name, joint_of
from service.effects.ports import ParameterSpec, Port, PortKind, Rows, Setting, Term

NAME = "joint_gain"
_WIDTH = 1e-3  # gear ratios are exact; scale errors of encoders stay well below this


class JointGain:
    """One factor per joint on its own angle."""

    name = NAME

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return one gain per joint, the first included: no other parameter scales its angle."""
        return tuple(
            ParameterSpec(joint_name("gain", joint), "1", 0.0, _WIDTH)
            for joint in range(setting.robot.n_joints)
        )

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn the joint by gain times its own angle."""
        joints = [joint_of(name) for name in names]
        return [Term(k, Port(PortKind.THETA, j), rows.turn_rad[:, j]) for k, j in enumerate(joints)]
