"""Base shift: the base jumped once (somebody drove against the table, a foot screw gave way).

The shift is that of the base's own origin, along the base's axes: the six components of body 0 move by their
parameters from a moment on (`effects.motions`).
"""

import numpy as np

from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, Signature, has_spread
from truepose.effects.motions import (
    Motion,
    Widths,
    around,
    fitted_motion,
    gaps_of_all,
    jump_terms,
    jump_time_s,
    motion_specs,
    split_motion,
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
    """Six components from a moment on that only a search in the data finds."""

    name = NAME
    needs: frozenset[Need] = frozenset({"time"})
    traits = frozenset({Trait.SEARCHED})
    signature = Signature("base", "time", "jump", "length of the translation", drawn="shift")

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
        # In the order of time, as somebody would tell it.
        prefixes = sorted({split_motion(name)[0] for name in fitted.names}, key=jump_time_s)
        motions = [_of(fitted, prefix) for prefix in prefixes]
        largest = int(np.argmax([motion.shift[0] for motion in motions]))
        amplitude, uncertainty = motions[largest].shift
        details = [
            detail
            for prefix, motion in zip(prefixes, motions, strict=True)
            for detail in (_when(scene, prefix), *motion.details())
        ]
        after = spoken(jump_time_s(prefixes[largest]) - scene.origin_s)
        sentence = message(
            "causes.base_shift", shift_mm=amplitude, turn_deg=motions[largest].turn_deg[0], after=after
        )
        more = message("causes.base_shift.several", jumps=len(prefixes)) if len(prefixes) > 1 else ""
        return Description(subject, amplitude, "mm", uncertainty, together(sentence, more), tuple(details))


def _of(fitted: FittedCause, chosen: str) -> Motion:
    return fitted_motion(fitted, lambda prefix: float(prefix == chosen))


def _when(scene: Scene, prefix: str) -> Detail:
    """Return the time of a jump: anywhere within its gap, evenly spread, hence width / sqrt(12)."""
    time_s = jump_time_s(prefix)
    found = gaps_of_all(scene)
    width_s = around(found, time_s).width_s if found else 0.0
    return Detail("time", time_s, "s", width_s / float(np.sqrt(12.0)))
