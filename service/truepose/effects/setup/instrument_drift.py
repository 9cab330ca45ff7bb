"""Instrument drift: the tracker's frame moves slowly (tripod, warming up), and with it all that it reads.

The shift is that of readings at the world's origin: the six components of the instrument's motion move by
rate times way (`effects.drifts`). It can be told from a drift of the base only where fixed nests are read
now and then: they stand still beside a base that moves.
"""

from dataclasses import replace

from truepose.effects.causes import Description, FittedCause, Scene, Signature
from truepose.effects.ports import Port, PortKind, Rows, Term, Trait
from truepose.effects.rigid_drifts import RigidDrift, describe_drift, drift_terms
from truepose.messages.message import Text, message, together

NAME = "instrument_drift"


class InstrumentDrift(RigidDrift):
    """Six drift rates, constant or settling."""

    name = NAME
    place = prefix = "tracker"
    traits = frozenset({Trait.ON_FIXED_NESTS})
    signature = Signature("tracker", "time", "drift", "translation speed", searched="settling", drawn="shift")

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move everything that is read: weight the way per rate [h]."""
        return drift_terms(names, rows, lambda component: Port(PortKind.INSTRUMENT, component))

    def unseen(self, scene: Scene) -> Text | None:
        """Need times, and an instrument that has a frame."""
        # A ballbar hangs between two balls and has no frame of its own.
        if scene.legs:
            return message("unseen.no_frame")
        return super().unseen(scene)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how fast the readings move, and whether anything but the instrument could have moved them."""
        shown = describe_drift(subject, fitted, scene, message("causes.instrument_drift"))
        seen = scene.reference_s.size
        nests = "causes.instrument_drift.nests_move" if seen else "causes.instrument_drift.no_nests"
        return replace(shown, sentence=together(shown.sentence, message(nests)))
