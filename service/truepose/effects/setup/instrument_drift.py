"""Instrument drift: the tracker's frame moves slowly (tripod, warming up), and with it all that it reads.

The shift is that of readings at the world's origin: the six components of the instrument's motion move by
rate times way (`effects.drifts`). It can be told from a drift of the base only where fixed nests are read
now and then: they stand still beside a base that moves.
"""

from dataclasses import replace

from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.motions import without_times
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.effects.rigid_drifts import (
    LINEAR,
    describe_drift,
    drift_candidates,
    drift_specs,
    drift_terms,
    is_endless_drift,
)
from truepose.messages.message import Text, message, together

NAME = "instrument_drift"
_PREFIX = "tracker"


class InstrumentDrift:
    """Six rates, even or settling."""

    name = NAME
    needs: frozenset[Need] = frozenset({"time"})
    traits = frozenset({Trait.ON_FIXED_NESTS})
    signature = Signature(
        "tracker", "time", "drift", "speed of the translation", searched="settling", drawn="shift"
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the rates of an even drift."""
        return drift_specs(_PREFIX, LINEAR)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move everything that is read: weight the way per rate [h]."""
        return drift_terms(names, rows, lambda component: Port(PortKind.INSTRUMENT, component))

    def goes_on(self, names: tuple[str, ...]) -> bool:
        """Return whether one of the shapes has no end of its own."""
        return is_endless_drift(names)

    def unseen(self, scene: Scene) -> Text | None:
        """Need times, and an instrument that has a frame."""
        # A ballbar hangs between two balls and has no frame of its own.
        if scene.legs:
            return message("unseen.no_frame")
        return without_times(scene)

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose an even drift and settling ones."""
        return () if self.unseen(scene) else drift_candidates(NAME, "tracker", _PREFIX, scene)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how fast the readings move, and whether anything but the instrument could have moved them."""
        shown = describe_drift(subject, fitted, scene, message("causes.instrument_drift"))
        seen = scene.reference_s.size
        nests = "causes.instrument_drift.nests_move" if seen else "causes.instrument_drift.no_nests"
        return replace(shown, sentence=together(shown.sentence, message(nests)))
