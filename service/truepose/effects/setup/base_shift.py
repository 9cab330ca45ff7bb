"""Base shift: the base jumped once (somebody drove against the table, a foot screw gave way).

The shift is that of the base's own origin, along the base's axes: the six components of body 0 move by their
parameters from a moment on (`effects.motions`).
"""

from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature, has_spread
from truepose.effects.motions import (
    Widths,
    fitted_jumps,
    gaps_of_all,
    jump_terms,
    motion_specs,
    spoken,
    tried,
    without_times,
)
from truepose.effects.ports import Need, ParameterSpec, Rows, Setting, Term, Trait, motion_port
from truepose.messages.message import Text, message, together

NAME = "base_shift"
_BASE = 0
_WIDTHS = Widths(0.5, 5e-4)  # five times a jump that spoils a calibration unnoticed


class BaseShift:
    """Six components of a shift, at a time found by searching the data."""

    name = NAME
    needs: frozenset[Need] = frozenset({"time"})
    traits = frozenset({Trait.SEARCHED})
    signature = Signature("base", "time", "jump", "translation distance", drawn="shift")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return none: when it jumped is not known beforehand."""
        return ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move the base from the jump on: weight 0 before it, 1 from it on."""
        return jump_terms(names, rows, lambda _prefix, component: motion_port(_BASE, component))

    def unseen(self, scene: Scene) -> Text | None:
        """Need times and several stops before and after."""
        if not has_spread(scene.stops.time_s):
            return without_times(scene)
        if not gaps_of_all(scene):
            return message("unseen.few_readings")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose every gap between stops that has readings enough on either side."""
        proposed = (
            Candidate(NAME, "base", motion_specs(f"jump_{gap.label}", _WIDTHS), gap.middle_s)
            # A jump lies between two stops, and anywhere else in the same gap it moves the same readings.
            for gap in tried(gaps_of_all(scene), scene.between_s)
        )
        return tuple(candidate for candidate in proposed if candidate.names[0] not in scene.present)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how far the base jumped, and when; of several jumps the largest is the amplitude."""
        jumps = fitted_jumps(fitted)
        time_s, largest = jumps.largest
        amplitude, uncertainty = largest.shift
        sentence = message(
            "causes.base_shift",
            shift_mm=amplitude,
            turn_deg=largest.turn_deg[0],
            after=spoken(time_s - scene.origin_s),
        )
        count = len(jumps.motions)
        more = message("causes.base_shift.several", jumps=count) if count > 1 else ""
        details = jumps.details(gaps_of_all(scene))
        return Description(subject, amplitude, "mm", uncertainty, together(sentence, more), details)
