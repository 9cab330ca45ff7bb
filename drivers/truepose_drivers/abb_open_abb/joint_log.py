"""The logger's stream, as far as it tells the joints while the motion server is busy.

It is listened to during a motion only: nobody would read it otherwise, and what waits unread is old.
"""

import asyncio
from typing import Final

from truepose_drivers.abb_open_abb.protocol import LogReader
from truepose_drivers.arm_options import Angles
from truepose_drivers.errors import DriverError
from truepose_drivers.transports.link import Link, drain

_FRESH_WITHIN_S: Final = 1.0  # wall time; a controller sends ten records a second or more
_JOINTS: Final = 1  # kind of record


class JointLog:
    """The stream of one controller."""

    def __init__(self, link: Link) -> None:
        self._link = link

    async def close(self) -> None:
        """Listen no more; never raises."""
        await self._link.close()

    async def joints_deg(self) -> Angles | None:
        """Return the joints that are told from now on, None where none are; never raises."""
        try:
            async with asyncio.timeout(_FRESH_WITHIN_S):
                if not self._link.is_open:
                    await self._link.open()
                await drain(self._link)
                return await self._next_joints_deg()
        except (DriverError, TimeoutError):
            await self._link.close()
            return None

    async def _next_joints_deg(self) -> Angles:
        records = LogReader()
        while True:
            records.receive_data(await self._link.receive(_FRESH_WITHIN_S) or b"")
            while (record := records.next_line()) is not None:
                if record.kind == _JOINTS:
                    return record.values
