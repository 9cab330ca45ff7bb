"""Base drift: the base moves slowly under the arm (a floor that warms up, a foot that settles).

The shift is that of the base's own origin, along the base's axes: body 0 of the chain, whose six components
move by rate times way (`effects.drifts`).
"""

from dataclasses import replace

from truepose.effects.causes import Description, FittedCause, Scene, Signature
from truepose.effects.ports import Rows, Term, motion_port
from truepose.effects.rigid_drifts import RigidDrift, describe_drift, drift_terms
from truepose.messages.message import message, together

NAME = "base_drift"
_BASE = 0


class BaseDrift(RigidDrift):
    """Six drift rates, constant or settling."""

    name = NAME
    place = "base"
    prefix = "drift"
    signature = Signature("base", "time", "drift", "translation speed", searched="settling", drawn="shift")

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the base as far as it has come: weight the way per rate [h]."""
        return drift_terms(names, rows, lambda component: motion_port(_BASE, component))

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how fast the base moves, and whether anything but the base could have moved the readings."""
        shown = describe_drift(subject, fitted, scene, message("causes.base_drift"))
        # Lengths have no frame of an instrument that could drift in the base's place.
        if scene.legs:
            return shown
        nests = "causes.base_drift.nests_stay" if scene.reference_s.size else "causes.base_drift.no_nests"
        return replace(shown, sentence=together(shown.sentence, message(nests)))
