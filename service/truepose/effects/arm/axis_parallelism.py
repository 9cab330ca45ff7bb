"""Axis parallelism: an axis that should be parallel to the one before it is tilted out of their plane.

The tilt is Hayati's beta, about the direction that is perpendicular to the axis before and to the common
normal. Alpha, a, theta and d cannot express it: the common normal of parallel axes may lie anywhere.

Source: S. A. Hayati, Proc. 22nd IEEE Conf. Decision and Control, 1983, 1477-1483.
"""

import numpy as np

from truepose.domain.diagnosis import Detail
from truepose.effects.arm.geometry import ANGLE_WIDTH_RAD, is_parallel_to_previous, link_terms
from truepose.effects.causes import (
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    Scene,
    Signature,
    norm_with_uncertainty,
)
from truepose.effects.names import joint_name, joint_of, joint_subject
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Rows, Setting, Term, Trait
from truepose.messages.message import Text, message

NAME = "axis_parallelism"


class AxisParallelism:
    """Beta of axes that are nominally parallel to the previous one, for models without it."""

    name = NAME
    needs: frozenset[Need] = NOTHING
    traits = frozenset({Trait.STEADY})
    signature = Signature(OF_SUBJECT, "constant", "group", "angle between the two axes")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return beta of every near-parallel axis."""
        joints = range(setting.robot.n_joints)
        return tuple(_spec(joint) for joint in joints if is_parallel_to_previous(setting.robot, joint))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on beta of the joint, one to one."""
        # The same port as the geometry's beta: models without it (`geometry_dhm`) are those that lack it.
        return list(link_terms(names))

    def unseen(self, scene: Scene) -> Text | None:
        """Need axes that are meant to be parallel."""
        if not self.specs(scene.setting):
            return message("unseen.no_parallel_axes")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each near-parallel axis whose tilt is not in the model."""
        return tuple(
            Candidate(NAME, joint_subject(joint_of(spec.name)), (spec,))
            for spec in self.specs(scene.setting)
            # The full geometry has them as parameters: then there is nothing that it could lack.
            if spec.name not in scene.present
        )

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say by which angle the axes are not parallel."""
        # Without its sign, which follows from the sense of a table's axes; the detail beside it has it.
        tilt, uncertainty = norm_with_uncertainty(fitted.values, fitted.covariance)
        tilt_deg, uncertainty_deg = float(np.rad2deg(tilt)), float(np.rad2deg(uncertainty))
        joint = joint_of(fitted.names[0]) + 1
        sentence = message("causes.axis_parallelism", first=joint - 1, second=joint, tilt_deg=tilt_deg)
        beta = Detail("beta", float(np.rad2deg(fitted.values[0])), "deg", uncertainty_deg)
        return Description(subject, tilt_deg, "deg", uncertainty_deg, sentence, (beta,))


def _spec(joint: int) -> ParameterSpec:
    return ParameterSpec(joint_name("beta", joint), "rad", 0.0, ANGLE_WIDTH_RAD)
