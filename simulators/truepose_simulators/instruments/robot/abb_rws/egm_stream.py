"""EGM: the controller streams where its joints are, 250 times a second, to the computer that it was told.

Who answers is heard and not followed: this is a stream of positions, by which nobody guides the arm.
"""

import asyncio
import contextlib
import itertools
from typing import Final

import numpy as np

from truepose_drivers.abb_egm.protocol import COUNTED_TO, Motors, Rapid, RobotFrame, encode_robot
from truepose_drivers.abb_rws.protocol import ControllerState
from truepose_simulators.errors import EndpointUnavailableError
from truepose_simulators.instruments.cable import Cable
from truepose_simulators.instruments.endpoint import Address
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController

_PERIOD_S: Final = 0.004


class EgmStream:
    """The stream of one controller to `computer_port`."""

    def __init__(self, controller: AbbController, computer_port: int) -> None:
        self.device = "robot-egm"
        self.cable = Cable()
        self._controller = controller
        self._computer_port = computer_port
        self._sending: asyncio.Task[None] | None = None
        self._numbers = itertools.count()

    async def open(self, host: str, port: int) -> Address:
        """Send from `port` to the computer at `host`, which is announced; raises EndpointUnavailableError."""
        loop = asyncio.get_running_loop()
        try:
            self._transport, _ = await loop.create_datagram_endpoint(
                asyncio.DatagramProtocol, local_addr=(host, port)
            )
        except OSError as error:
            raise EndpointUnavailableError(
                f"the robot cannot stream from {host}:{port}: {error.strerror}; choose another port"
            ) from error
        self._sending = asyncio.create_task(self._send((host, self._computer_port)))
        return Address(self.device, "egm", host, self._computer_port)

    async def close(self) -> None:
        """Send no more."""
        if self._sending is not None:
            self._sending.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._sending
            self._transport.close()

    async def _send(self, computer: tuple[str, int]) -> None:
        # A stream cannot run in cell time that stands still: its period is wall time.
        while True:
            if self.cable.passes:
                self._transport.sendto(encode_robot(self.frame()), computer)
            await asyncio.sleep(_PERIOD_S)

    def frame(self) -> RobotFrame:
        """Return what is sent now."""
        cell = self._controller.cell
        return RobotFrame(
            sequence=next(self._numbers) % COUNTED_TO,
            time_ms=int(1000.0 * asyncio.get_running_loop().time()) % COUNTED_TO,
            joints_deg=tuple(np.degrees(cell.joints_rad).tolist()),
            planned_deg=tuple(np.degrees(cell.robot.target_rad).tolist()),
            motors=Motors.ON if self._controller.state is ControllerState.MOTORS_ON else Motors.OFF,
            rapid=Rapid.RUNNING if self._controller.runs else Rapid.STOPPED,
        )
