"""An endpoint for one client: the next one is let in after a pause, a second one hears nothing meanwhile."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import EndpointUnavailableError
from truepose_simulators.instruments.endpoint import Endpoint

_ACCEPT_PAUSE_S = 0.5

Attend = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


class OneClientEndpoint:
    """An endpoint that serves one client and pauses between two."""

    def __init__(self, device: str, protocol: str, attend: Attend, *, pause_s: float) -> None:
        self.endpoint = Endpoint(device, protocol, self._serve)
        self._attend = attend
        self._pause_s = pause_s
        self._free = asyncio.Event()
        self._free.set()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if not self._free.is_set():
            await self._free.wait()
            return
        self._free.clear()
        try:
            await self._attend(reader, writer)
        finally:
            writer.close()
            self._free.set()
        if self._pause_s > 0.0:
            self.endpoint.stop_listening()
            await self._listen_after_pause()

    async def _listen_after_pause(self) -> None:
        while True:
            await asyncio.sleep(self._pause_s)
            # Meanwhile the system may have lent the port to somebody's outgoing connection: try again.
            with contextlib.suppress(EndpointUnavailableError):
                await self.endpoint.listen_again()
                return


def one_client_endpoint(device: str, protocol: str, attend: Attend, cell: Cell) -> Endpoint:
    """Build the endpoint of a program that serves one client at a time."""
    # At pace 0 nobody waits in wall time, not even for the controller's pause.
    pause_s = _ACCEPT_PAUSE_S if cell.clock.waits else 0.0
    return OneClientEndpoint(device, protocol, attend, pause_s=pause_s).endpoint
