"""Payload: the tool weighs something else, or elsewhere, than everybody was told.

Mass and first moment of the flange frame add torques (`effects.arm.loads`), which wind up the springs.
"""

import numpy as np

from truepose.effects.arm import loads
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import Need, ParameterSpec, Rows, Setting, Term
from truepose.messages.message import Text, message

NAME = "payload"
_NAMES = ("payload_mass", "payload_x", "payload_y", "payload_z")


class Payload:
    """Deviation of mass and first moment of the tool from the stated values, in the flange frame."""

    name = NAME
    needs: frozenset[Need] = frozenset({"torque"})
    signature = Signature("tool", "load", "line", "deviation of the tool mass")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return mass and three first moments where torques come from masses."""
        if setting.torque_source != "masses":
            return ()
        return loads.mass_specs(_NAMES, loads.stated_mass(setting.robot, setting.robot.n_joints - 1))

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Load the joints: torques [N mm] per kg or per kg mm, one for each joint."""
        last = rows.robot.n_joints - 1
        return [
            term
            for k, name in enumerate(names)
            for term in loads.mass_terms(k, last, name.removeprefix("payload_"), rows)
        ]

    def unseen(self, scene: Scene) -> Text | None:
        """Need springs that gravity loads."""
        return loads.unseen_masses(scene)

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose the tool's mass and centre of gravity."""
        # All four or none: amount and centre of gravity are told apart only together.
        if loads.unseen_masses(scene) is not None or not scene.present.isdisjoint(_NAMES):
            return ()
        return (Candidate(NAME, "tool", self.specs(scene.setting)),)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how much heavier the tool is and where its centre of gravity lies."""
        stated = loads.stated_mass(scene.setting.robot, scene.setting.robot.n_joints - 1)
        wrong = loads.wrong_mass(fitted, self.specs(scene.setting), stated)
        sentence = message(
            "causes.payload.more" if wrong.extra_kg >= 0.0 else "causes.payload.less",
            extra_kg=abs(wrong.extra_kg),
            stated_kg=stated.mass_kg,
            shift_mm=float(np.linalg.norm(wrong.shift_mm)),
        )
        return Description(
            subject,
            wrong.extra_kg,
            "kg",
            wrong.extra_spread_kg,
            sentence,
            wrong.details(),
            loads.mass_limits(stated),
        )
