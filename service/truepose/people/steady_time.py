"""The time of day as nobody can set it while the service runs.

What expires does so by this time: a clock that is put back makes no token live longer. It begins with the
time of day, never before the newest record, and goes on by the computer's monotonic clock.
"""

import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta


def since_boot_s() -> float:
    """Return a time that only goes forward, through sleep as well where the system counts it."""
    clock = getattr(time, "CLOCK_BOOTTIME", None)
    return time.monotonic() if clock is None else time.clock_gettime(clock)


def time_of_day() -> datetime:
    """Return what the computer's clock says."""
    return datetime.now(UTC)


class SteadyTime:
    """A time of day that only goes forward."""

    def __init__(
        self,
        newest: str | None = None,
        wall: Callable[[], datetime] = time_of_day,
        elapsed_s: Callable[[], float] = since_boot_s,
    ) -> None:
        """Begin at the time of day, or at the newest record (UTC, ISO 8601) where that is later."""
        recorded = datetime.min.replace(tzinfo=UTC) if newest is None else datetime.fromisoformat(newest)
        self.elapsed_s = elapsed_s
        # A clock that was put back before the start would make what has expired live again.
        self._began = max(wall(), recorded)
        self._began_s = elapsed_s()

    def now(self) -> datetime:
        """Return the time of day."""
        return self._began + timedelta(seconds=self.elapsed_s() - self._began_s)

    def in_future(self, days: float, since: str | None = None) -> str:
        """Return the time so many days ahead of now, or of a time, as records have it."""
        begin = self.now() if since is None else datetime.fromisoformat(since)
        return (begin + timedelta(days=days)).isoformat(timespec="milliseconds")

    def is_over(self, until: str | None) -> bool:
        """Whether a time is reached; none never is."""
        return until is not None and datetime.fromisoformat(until) <= self.now()
