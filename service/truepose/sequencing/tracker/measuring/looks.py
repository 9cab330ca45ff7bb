"""Looks at the reflector for whoever watches; the driver that answers may fail, hang or talk nonsense."""

import asyncio
import logging
from typing import Final

from truepose.domain.measurement.session import Vector
from truepose_drivers.api import FullTracker
from truepose_drivers.errors import (
    ConnectionLostError,
    DeviceRefusedError,
    MeasurementFailedError,
    NotInitialisedError,
)

_LOG: Final = logging.getLogger(__name__)
_PATIENCE_S: Final = 30.0  # wall time, besides the measurement that a look waits for
_LAST_LOOK_S: Final = 2.0  # wall time that the end of a session leaves to a look
_HARMLESS: Final = (
    ConnectionLostError,  # no doing of the look
    DeviceRefusedError,
    MeasurementFailedError,
    NotInitialisedError,
)


class Looks:
    """Asks a tracker where its reflector is; no answer of its driver is an error here.

    A look that goes wrong costs the link, and with it the measurement's next step: after one there are no
    more of them.
    """

    def __init__(self, tracker: FullTracker, measure_s: float) -> None:
        self._tracker = tracker
        self._patience_s = measure_s + _PATIENCE_S
        self._look: asyncio.Future[Vector | None] | None = None  # under way
        self._given_up = False

    async def seen_mm(self) -> Vector | None:
        """Return where the reflector is, in the tracker's frame; None where it sees none."""
        if self._given_up or not self._tracker.connected:
            return None
        # A task of its own: one that is broken off in its middle would close the link of the measurement.
        self._look = asyncio.ensure_future(self._tracker.reflector_now())
        return await self._answer(self._look, self._patience_s)

    async def end(self) -> None:
        """Let a look under way come to its end, or break it off where it hangs."""
        if self._look is not None and not self._look.done():
            await self._answer(self._look, _LAST_LOOK_S)

    async def _answer(self, look: asyncio.Future[Vector | None], patience_s: float) -> Vector | None:
        if not (await asyncio.wait({look}, timeout=patience_s))[0]:
            look.cancel()
            self._give_up(f"no answer within {patience_s:g} s")
            return None
        try:
            return look.result()
        except _HARMLESS:
            return None  # whatever it means is found by the next measurement
        except (Exception, asyncio.CancelledError) as error:  # the look's own, for nobody cancels it
            self._give_up(f"{type(error).__name__}: {error}")
            return None

    def _give_up(self, why: str) -> None:
        self._given_up = True
        _LOG.warning("where the reflector is, is shown no more in this session: %s", why)
