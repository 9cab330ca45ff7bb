"""Base compliance: the base tilts under the arm's weight, as a slender pedestal or a thin table top does.

    turn of body 0 = c M        M = sum of m_j (c_j - o_base) x g, in the base's axes

The base turns, about its own origin, by its compliance times the moment of all weights about that origin:
r x m g has no part along gravity, so that this is a tilt about a horizontal axis. Own derivation.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.causes import SPRING, Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Rows, Setting, Term, motion_port
from truepose.kinematics.frames import cross
from truepose.kinematics.gravity import centre_of_gravity
from truepose.messages.message import Text, message

NAME = "base_compliance"
_PARAMETER = "base_c"
_BASE = 0
_FIRST_TURN = 3  # components 3..5 of a motion
_WIDTH = 3e-8  # rad/(N mm): belief, six times a table that visibly gives


class BaseCompliance:
    """One compliance about all horizontal axes."""

    name = NAME
    # Weights tilt the base where the masses are known; no torque about a joint takes part.
    needs: frozenset[Need] = NOTHING
    signature = Signature("base", "load", "line", "base tilt per unit moment")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the compliance where the masses are known."""
        return (ParameterSpec(_PARAMETER, "rad/(N*mm)", 0.0, _WIDTH),) if setting.robot.masses else ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn the base with the moment of all weights: its components [N mm] on the turns of body 0."""
        if not names:
            return []
        moment = _overturning_moment(rows)
        return [
            Term(k, motion_port(_BASE, _FIRST_TURN + axis), moment[:, axis])
            for k in range(len(names))
            for axis in range(3)
        ]

    def unseen(self, scene: Scene) -> Text | None:
        """Need known masses."""
        if not scene.setting.robot.masses:
            return message("unseen.moments_unknown")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose a base that tilts."""
        if self.unseen(scene) is not None or _PARAMETER in scene.present:
            return ()
        return (Candidate(NAME, "base", self.specs(scene.setting)),)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how far the base tilts."""
        compliance, spread = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        sentence = message("causes.base_compliance", compliance=compliance)
        return Description(subject, compliance, "rad/(N*mm)", spread, sentence, limits=SPRING)


def _overturning_moment(rows: Rows) -> FloatArray:
    """Moment of all weights about the base's origin, in its axes, shape (n, 3) [N mm]."""
    chain = rows.chain
    moment = np.zeros((len(rows.stops), 3))
    for mass in rows.robot.masses:
        arm = centre_of_gravity(chain, mass) - chain.base_origin
        moment += cross(arm, mass.mass_kg * rows.gravity_m_s2)
    # The base's own axes: ports of body 0 turn about these, and the base may stand askew.
    in_base: FloatArray = np.einsum("nij,ni->nj", chain.base_rotation, moment)
    return in_base
