"""Instrument scale: every length of the instrument is off by one factor."""

from service.effects.ports import NOTHING, Need, ParameterSpec, Port, PortKind, Rows, Setting, Term

NAME = "instrument_scale"
_WIDTH = 1e-4  # ten times what a tracker in a workshop without weather station would show


class InstrumentScale:
    """One factor on all lengths, about the place of the instrument."""

    name = NAME
    needs: frozenset[Need] = NOTHING

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the relative scale error."""
        return (ParameterSpec("scale", "1", 0.0, _WIDTH),)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Act on the scale port."""
        return [Term(k, Port(PortKind.SCALE, 0), 1.0) for k in range(len(names))]
