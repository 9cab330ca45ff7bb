"""Whether the ballbar sits where it sat when a length was last taken.

The same connection must not be stored twice by itself. A ballbar that leaves its cups loses its signal or
runs out of its range, so what follows is a new connection. Where that was too quick to be seen the length
has jumped: between two samples, and to another value than the one that was taken. A slow drift is neither.
"""

from typing import Final

# Twenty times the scatter of a reading and three times what the zero walks by; two legs of a pose agree as
# well as that by chance once in fifty times, and the button is there.
JUMP_MM: Final = 0.01


class Contact:
    """Follows the raw deviation of the ballbar [mm]."""

    def __init__(self) -> None:
        self._taken_mm: float | None = None
        self._taken_for = ""
        self._lost = True
        self._jumped = False
        self._before_mm: float | None = None

    def note(self, deviation_mm: float | None) -> None:
        """Take the next sample; None without a usable signal."""
        if deviation_mm is None:
            self._lost = True
        elif self._before_mm is not None and abs(deviation_mm - self._before_mm) > JUMP_MM:
            self._jumped = True
        self._before_mm = deviation_mm

    def take(self, deviation_mm: float, step_id: str) -> None:
        """Remember that a length was taken here for a step; "" where it is not what was asked for."""
        self._taken_mm = deviation_mm
        self._taken_for = step_id
        self._lost = self._jumped = False

    def distrust(self) -> None:
        """Let nothing but a lost signal count as new: values are counted from elsewhere now."""
        self._taken_mm = None
        self._lost = self._jumped = False

    def forget(self) -> None:
        """Let the present connection be read again: a person wants that."""
        self._lost = True

    def held_for(self, deviation_mm: float) -> str | None:
        """Return the step for which what is connected was taken already; None where it is new."""
        return None if self.is_new(deviation_mm) else self._taken_for

    def is_new(self, deviation_mm: float) -> bool:
        """Whether a length that stands at this deviation belongs to another connection."""
        if self._lost or self._taken_mm is None:
            return self._lost
        return self._jumped and abs(deviation_mm - self._taken_mm) > JUMP_MM
