"""The ballbar's link: a cable that is pulled is no fault of the session, which goes on when it is back."""

from typing import Final

from drivers.api import Ballbar, BallbarReading, Clock
from drivers.errors import ConnectionLostError, DriverError, LinkError

_FIRST_WAIT_S: Final = 0.25
_LONGEST_WAIT_S: Final = 4.0
_SAYS_NOTHING: Final = frozenset({"", "unknown"})


class Gauge:
    """Reads the ballbar and opens its link anew, after waits that grow, when it is lost."""

    def __init__(self, ballbar: Ballbar, clock: Clock) -> None:
        self._ballbar = ballbar
        self._clock = clock
        self._wait_s = _FIRST_WAIT_S
        self._try_again_s: float | None = None
        self.trouble: str | None = None  # why there is no reading
        self.serial: str = ""  # as the device says it
        self.lost_power = False  # it was gone: its zero may be gone with it

    async def read(self) -> BallbarReading | None:
        """Return the newest reading, None while there is none."""
        try:
            if not self._ballbar.connected and not await self._connect():
                return None
            reading = await self._ballbar.read()
        except DriverError as error:
            await self._give_up(error)
            return None
        self.trouble = None
        self._wait_s = _FIRST_WAIT_S
        return reading

    async def close(self) -> None:
        """Close the link."""
        await self._ballbar.close()

    async def _connect(self) -> bool:
        """Open the link where the wait is over; returns whether it is open. Raises DriverError."""
        if self._try_again_s is not None:
            left_s = self._try_again_s - await self._clock.now_s()
            if 0.0 < left_s <= _LONGEST_WAIT_S:  # more is left only where the cell's clock began anew
                return False
        await self._ballbar.connect()
        serial = (await self._ballbar.identify()).serial
        self.serial = "" if serial in _SAYS_NOTHING else serial
        self._try_again_s = None
        return True

    async def _give_up(self, error: DriverError) -> None:
        self.trouble = str(error)
        # a counter that falls silent keeps its zero; a gauge that vanishes has lost its supply
        self.lost_power |= isinstance(error, ConnectionLostError)
        if isinstance(error, LinkError) or not self._ballbar.connected:
            await self._ballbar.close()
        self._try_again_s = await self._clock.now_s() + self._wait_s
        self._wait_s = min(2.0 * self._wait_s, _LONGEST_WAIT_S)
