"""A device's own count of its readings, which must go on: one that stands still says that it hangs."""

from typing import Final

from truepose_drivers.api import BallbarReading
from truepose_drivers.errors import RemoteProtocolError

_LONGEST_S: Final = 1.0  # cell time; whoever asks faster than the device measures hears one reading twice


class StandingCount:
    """Compares each reading of a connection with those before it."""

    def __init__(self) -> None:
        self._sequence: int | None = None
        self._since_s = 0.0

    def require_going_on(self, reading: BallbarReading) -> None:
        """Raise RemoteProtocolError for a count that has stood still for longer than a second."""
        if reading.sequence is None or reading.sequence != self._sequence:
            self._sequence, self._since_s = reading.sequence, reading.time_s
        elif reading.time_s - self._since_s > _LONGEST_S:
            raise RemoteProtocolError(
                f"the device has repeated its reading {reading.sequence} for"
                f" {reading.time_s - self._since_s:.1f} s: it hangs; unplug it and plug it in again"
            )
