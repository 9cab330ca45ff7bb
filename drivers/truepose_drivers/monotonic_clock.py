"""The computer's monotonic time as the clock of a real cell."""

import asyncio
import time

from truepose_drivers.api import Clock, DriverPlugin, Options


class MonotonicClock:
    """Seconds since an arbitrary start; never steps, not even when the computer's date is set."""

    async def now_s(self) -> float:
        """Return the present time [s]."""
        return time.monotonic()

    async def sleep(self, duration_s: float) -> None:
        """Wait for `duration_s`."""
        await asyncio.sleep(duration_s)


def _open(options: Options, clock: Clock) -> MonotonicClock:
    return MonotonicClock()


PLUGIN = DriverPlugin(
    name="monotonic_clock",
    kind="clock",
    protocol="none",
    options={},
    open=_open,
)
