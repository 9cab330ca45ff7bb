"""Base drift: the base moves slowly under the arm (a floor that warms up, a foot that settles).

The shift is that of the base's own origin, along the base's axes: body 0 of the chain, whose six components
move by rate times way (`effects.drifts`).
"""

from dataclasses import replace

from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.motions import without_times
from truepose.effects.ports import Need, ParameterSpec, Rows, Setting, Term, motion_port
from truepose.effects.rigid_drifts import (
    LINEAR,
    describe_drift,
    drift_candidates,
    drift_specs,
    drift_terms,
    is_endless_drift,
)
from truepose.messages.message import Text, message, together

NAME = "base_drift"
_PREFIX = "drift"
_BASE = 0


class BaseDrift:
    """Six rates, even or settling."""

    name = NAME
    needs: frozenset[Need] = frozenset({"time"})
    signature = Signature(
        "base", "time", "drift", "speed of the translation", searched="settling", drawn="shift"
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the rates of an even drift."""
        return drift_specs(_PREFIX, LINEAR)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the base as far as it has come: weight the way per rate [h]."""
        return drift_terms(names, rows, lambda component: motion_port(_BASE, component))

    def goes_on(self, names: tuple[str, ...]) -> bool:
        """Return whether one of the shapes has no end of its own."""
        return is_endless_drift(names)

    def unseen(self, scene: Scene) -> Text | None:
        """Need times."""
        return without_times(scene)

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose an even drift and settling ones."""
        return () if self.unseen(scene) else drift_candidates(NAME, "base", _PREFIX, scene)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how fast the base moves, and whether anything but the base could have moved the readings."""
        shown = describe_drift(subject, fitted, scene, message("causes.base_drift"))
        # Lengths have no frame of an instrument that could drift in the base's place.
        if scene.legs:
            return shown
        nests = "causes.base_drift.nests_stay" if scene.reference_s.size else "causes.base_drift.no_nests"
        return replace(shown, sentence=together(shown.sentence, message(nests)))
