"""Joint gain: a joint turns by a factor 1 + k of what it should (level 1 with an offset).

    theta_i moves by  k_i q_i        q_i the joint's own turn: its angle with its sign

Source: thesis of A. Nubiola, 2014, section 1.3 (theta_real = k1 theta + k0).
"""

import numpy as np

from truepose.effects.causes import (
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    OfTurningJoints,
    Scene,
    Signature,
)
from truepose.effects.names import joint_name, joint_of, joint_subject
from truepose.effects.ports import ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import message

NAME = "joint_gain"
_WIDTH = 1e-3  # gear ratios are exact; scale errors of encoders stay well below this


class JointGain(OfTurningJoints):
    """One factor per joint, on its own angle."""

    name = NAME
    traits = frozenset({Trait.STEADY})
    signature = Signature(
        OF_SUBJECT,
        "angle of {subject}",
        "line",
        "relative excess rotation of the joint",
        drawn="joint",
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return one gain per joint, the first included: no other parameter scales its angle."""
        return tuple(_spec(joint) for joint in range(setting.robot.n_joints))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn the joint by gain times its own angle: weight q [rad per 1] on its theta."""
        joints = [joint_of(name) for name in names]
        return [Term(k, Port(PortKind.THETA, j), rows.turn_rad[:, j]) for k, j in enumerate(joints)]

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each joint that turns."""
        return tuple(
            Candidate(NAME, joint_subject(j), (_spec(j),))
            # Over a few degrees a gain is an offset, and the offset is in the model already.
            for j in scene.turning
            if joint_name("gain", j) not in scene.present
        )

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say by how much the joint turns too far or not far enough."""
        gain, uncertainty = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        joint = joint_of(fitted.names[0])
        way = float(np.rad2deg(np.ptp(scene.turn_rad[:, joint]) * abs(gain)))
        key = "causes.joint_gain.too_far" if gain > 0 else "causes.joint_gain.not_far_enough"
        sentence = message(key, joint=subject, share=abs(gain), way_deg=way)
        return Description(subject, gain, "1", uncertainty, sentence)


def _spec(joint: int) -> ParameterSpec:
    return ParameterSpec(joint_name("gain", joint), "1", 0.0, _WIDTH)
