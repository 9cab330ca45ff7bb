"""Instrument scale: all lengths of the instrument are off by one factor (wavelength, air, wrong calibrator).

    p is read at  p + s (p - c)                 c the place of the tracker
    a length reads too much by  s l             l the length of the ballbar

A tracker's scale acts about its own place. The lengths of the arm follow a wrong scale unless something
certified is among the readings: fixed nests, or several nests of the tool.
"""

import numpy as np

from truepose.effects.causes import OF_SUBJECT, Candidate, Description, FittedCause, Scene, Signature
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.messages.message import Text, message

NAME = "instrument_scale"
_WIDTH = 1e-4  # ten times what a tracker in a workshop without weather station would show
_TRACKER, _BALLBAR = "scale", "ballbar_scale"
_LENGTHS_OF_THE_ARM = ("a_", "d_")


class InstrumentScale:
    """One scale factor on all lengths that a tracker or a ballbar reads."""

    name = NAME
    needs: frozenset[Need] = NOTHING
    traits = frozenset({Trait.ON_FIXED_NESTS, Trait.AGEING, Trait.SCALE})
    signature = Signature(OF_SUBJECT, "range", "line", "relative error of lengths", at="instrument")

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the relative scale error."""
        return (_spec(_BALLBAR if setting.lengths else _TRACKER),)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the scale of positions, weight 1, or on each length by itself, weight l [mm]."""
        return [_term(k, name, rows) for k, name in enumerate(names)]

    def unseen(self, scene: Scene) -> Text | None:
        """Need something of a certified size."""
        free = any(name.startswith(_LENGTHS_OF_THE_ARM) for name in scene.present)
        # Where no length of the arm is fitted, the table itself is the certified size.
        if free and scene.reference_s.size == 0 and len(scene.setting.certified_nests) < 2:
            return message("unseen.nothing_certified")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose the scale of the instrument that was used."""
        spec = _spec(_BALLBAR if scene.legs else _TRACKER)
        if self.unseen(scene) or spec.name in scene.present:
            return ()
        return (Candidate(NAME, "ballbar" if scene.legs else "tracker", (spec,)),)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say by how much lengths are read too long or too short."""
        scale, uncertainty = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        key = "causes.instrument_scale.long" if scale > 0 else "causes.instrument_scale.short"
        sentence = message(key, instrument=subject, um_per_m=abs(scale) * 1e6)
        return Description(subject, scale, "1", uncertainty, sentence)


def _spec(name: str) -> ParameterSpec:
    return ParameterSpec(name, "1", 0.0, _WIDTH)


def _term(k: int, name: str, rows: Rows) -> Term:
    if name == _TRACKER:
        return Term(k, Port(PortKind.SCALE, 0), 1.0)
    # A position is no length: of rows without one the scale of a ballbar moves nothing.
    length_mm = np.zeros(len(rows.stops)) if rows.length_mm is None else rows.length_mm
    return Term(k, Port(PortKind.LENGTH, 0), length_mm)
