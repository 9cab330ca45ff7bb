"""The ballbar's link: a cable that is pulled is no fault of the session, which goes on when it is back."""

import asyncio
from typing import Final

from truepose.sequencing.engine.identity.expected import told
from truepose_drivers.api import Ballbar, BallbarReading, Clock, DeviceIdentity
from truepose_drivers.errors import ConnectionLostError, DriverError, DriverFaultError, LinkError

_FIRST_WAIT_S: Final = 0.25
_LONGEST_WAIT_S: Final = 4.0


class Gauge:
    """Reads the ballbar and opens its link anew, after waits that grow, when it is lost."""

    def __init__(self, ballbar: Ballbar, clock: Clock) -> None:
        self._ballbar = ballbar
        self._clock = clock
        self._wait_s = _FIRST_WAIT_S
        self._try_again_s: float | None = None
        self.trouble: str | None = None  # why there is no reading
        self._turn = asyncio.Lock()  # one question at a time
        self.identity: DeviceIdentity | None = None  # as it last said itself; None before it did
        self.lost_power = False  # it was gone: its zero may be gone with it

    @property
    def serial(self) -> str:
        """Its serial number, empty where it tells none."""
        return "" if self.identity is None else told(self.identity.serial)

    async def read(self, *, ask: bool = False) -> BallbarReading | None:
        """Return the newest reading, None while there is none; `ask` it first who it is."""
        try:
            async with self._turn:
                if not self._ballbar.connected:
                    if not await self._connect():
                        return None
                elif ask:
                    self.identity = await self._ballbar.identify()
                reading = await self._ballbar.read()
        except DriverError as error:
            await self._give_up(error)
            return None
        self.trouble = None
        self._wait_s = _FIRST_WAIT_S
        return reading

    async def ask(self) -> None:
        """Ask again who it is; raises DriverError."""
        try:
            async with self._turn:
                self.identity = await self._ballbar.identify()
        except DriverError as error:
            await self._give_up(error)
            raise

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
        self.identity = await self._ballbar.identify()
        self._try_again_s = None
        return True

    async def _give_up(self, error: DriverError) -> None:
        self.trouble = str(error)
        # a counter that falls silent keeps its zero; a gauge that vanishes has lost its supply, and what was
        # behind a driver's own failure nobody knows
        self.lost_power |= isinstance(error, ConnectionLostError | DriverFaultError)
        if isinstance(error, LinkError) or not self._ballbar.connected:
            await self._ballbar.close()
        self._try_again_s = await self._clock.now_s() + self._wait_s
        self._wait_s = min(2.0 * self._wait_s, _LONGEST_WAIT_S)
