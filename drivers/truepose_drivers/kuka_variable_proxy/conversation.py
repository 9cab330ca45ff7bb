"""The conversation with a variable proxy, and through its variables with our program on the controller.

The proxy hangs up on whoever is silent for half a minute: it is pinged meanwhile.
"""

import asyncio
import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

from truepose_drivers.arm_motion import farthest_off, stopped_unheard
from truepose_drivers.arm_options import Angles
from truepose_drivers.errors import (
    DeviceRefusedError,
    DriverError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.kuka_variable_proxy import protocol
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OverPort, now_s

_PING_EVERY_S: Final = 10.0  # the proxy hangs up after 30 s

Value = TypeVar("Value")


class VariableProxy(OverPort):
    """Variables of a controller by their names."""

    def __init__(self, link: Link, *, reply_s: float) -> None:
        self._conversation = Conversation[protocol.Answer](
            link, protocol.AnswerReader, harmless=(DeviceRefusedError,)
        )
        super().__init__(self._conversation)
        self._reply_s = reply_s
        self._number = 0
        self._pinging: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Connect; raises ConnectFailedError."""
        await self._stop_pinging()
        await self._conversation.open()
        self._pinging = asyncio.create_task(self._ping())

    async def close(self) -> None:
        """End the connection; never raises."""
        await self._stop_pinging()
        await self._conversation.close()

    async def read(self, name: str, decode: Callable[[str], Value]) -> Value:
        """Return what a variable says; raises DeviceRefusedError where there is none of that name."""
        async with self._conversation.turn():
            answer = await self._answer(name)
            # The public server reads a variable that is not there as nothing, and says that it was done.
            if not answer.done or not answer.value:
                raise DeviceRefusedError(f"the robot has no variable {name}, or does not allow reading it")
            return decode(answer.value)

    async def write(self, name: str, value: str) -> None:
        """Write a variable; raises DeviceRefusedError where it cannot be written."""
        async with self._conversation.turn():
            if not (await self._answer(name, value)).done:
                raise DeviceRefusedError(f"the robot does not allow its variable {name} to be set to {value}")

    async def _answer(self, name: str, value: str | None = None) -> protocol.Answer:
        """Send a request and return its answer, by number and mode."""
        self._number = (self._number + 1) % protocol.NUMBERS
        request = protocol.Request(self._number, name, value)
        await self._conversation.drain()
        await self._conversation.send(
            protocol.encode_request(request),
            timeout_s=self._reply_s,
            silence=f"the proxy at {self._conversation.address} is connected but does not respond:"
            " check that its program runs on the controller, then connect again",
        )
        answer = await self._conversation.next()
        if (answer.number, answer.mode) != (request.number, request.mode):
            raise protocol.ProxyProtocolError(
                f"the proxy answers request {answer.number}, but request {request.number} was sent: connect"
                " again"
            )
        if not await self._conversation.is_quiet():
            raise protocol.ProxyProtocolError("the proxy sent more data than requested: connect again")
        return answer

    async def _ping(self) -> None:
        with contextlib.suppress(DriverError):  # whoever asks next is told
            while True:
                await asyncio.sleep(_PING_EVERY_S)
                async with self._conversation.turn():
                    await self._answer(protocol.Variable.PING)

    async def _stop_pinging(self) -> None:
        pinging, self._pinging = self._pinging, None
        if pinging is not None:
            pinging.cancel()
            await asyncio.wait({pinging})


_BEGINS_WITHIN_S: Final = 3.0  # from the order to the program's notice of it
_START: Final = "select and start the program TRUEPOSE on the controller, then confirm"


@dataclass(frozen=True, slots=True)
class Order:
    """A motion to be made."""

    axes_deg: Angles  # to which, additional axes included
    percent: int  # of the greatest speeds of the joints
    override_percent: int  # that must not be exceeded


class Program:
    """TRUEPOSE, which moves to a target while it hears beats."""

    def __init__(self, proxy: VariableProxy) -> None:
        self._proxy = proxy
        self._beat = 0

    async def ready(self) -> protocol.ProgramState:
        """Return the state of the program, which waits for an order; raises NotInitialisedError."""
        if await self._proxy.read(protocol.Variable.PROGRAM_STATE, protocol.decode_text) != protocol.ACTIVE:
            raise NotInitialisedError(f"no program runs on the robot: clear its messages, {_START}")
        if await self._proxy.read(protocol.Variable.DRIVES, protocol.decode_text) != "TRUE":
            raise NotInitialisedError(f"the robot's drives are not ready: switch them on, {_START}")
        try:
            state = await self._proxy.read(protocol.Variable.STATE, protocol.decode_state)
        except DeviceRefusedError as error:
            raise NotInitialisedError(
                f"the program TRUEPOSE is not on the controller: load it, {_START}"
            ) from error
        if state.moves:
            raise NotInitialisedError(
                "the robot is still moving, or stopped during a motion: wait for it, then confirm"
            )
        return state

    async def give(self, order: Order) -> None:
        """Write what a motion shall be, and see that it stands there."""
        await self._proxy.write(protocol.Variable.TARGET, protocol.encode_axes(order.axes_deg))
        await self._proxy.write(protocol.Variable.PERCENT, str(order.percent))
        await self._proxy.write(protocol.Variable.MOST_OVERRIDE, str(order.override_percent))
        # Variables have no owner: every program that is connected to the proxy may write these too.
        stands_deg = await self._proxy.read(protocol.Variable.TARGET, protocol.decode_axes)
        percent = await self._proxy.read(protocol.Variable.PERCENT, protocol.decode_count)
        override = await self._proxy.read(protocol.Variable.MOST_OVERRIDE, protocol.decode_count)
        speeds = (percent, override) == (order.percent, order.override_percent)
        if not speeds or _off_deg(stands_deg, order.axes_deg) > protocol.STEP_DEG:
            await self._proxy.close()
            raise protocol.ProxyProtocolError(
                "the robot does not keep what is written to the variables of TRUEPOSE: make sure that no"
                " other program writes them, then connect again"
            )

    async def carry_out(self, number: int, longest_s: float) -> None:
        """Have the order carried out under a number, and give beats until the arm has arrived."""
        await self._proxy.write(protocol.Variable.NUMBER, str(number))
        ordered_s = now_s()
        while not await self._arrived(number, now_s() - ordered_s):
            if now_s() - ordered_s > longest_s:
                await self._proxy.close()
                raise NoReplyError(
                    "the robot did not reach its target in time: check its pendant for a paused program, then"
                    " connect again"
                )
            await asyncio.sleep(protocol.BEAT_S)

    async def _arrived(self, number: int, since_s: float) -> bool:
        self._beat = protocol.following(self._beat)
        await self._proxy.write(protocol.Variable.BEAT, str(self._beat))
        state = await self._proxy.read(protocol.Variable.STATE, protocol.decode_state)
        if state.refused == number:
            raise TargetRefusedError("the robot refused it as outside its axis ranges")
        if state.given_up == number:
            raise stopped_unheard(protocol.SILENCE_S)
        if state.begun != number and since_s > _BEGINS_WITHIN_S:
            raise NotInitialisedError(f"the robot did not begin the motion: {_START}")
        if state.arrived != number:
            await self._require_running()
        return state.arrived == number

    async def _require_running(self) -> None:
        state = await self._proxy.read(protocol.Variable.PROGRAM_STATE, protocol.decode_text)
        if state != protocol.ACTIVE:
            raise NotInitialisedError(
                f"the robot stopped during the motion ({state}): check the messages on its pendant, reset"
                f" TRUEPOSE, {_START}"
            )


def _off_deg(stands_deg: Sequence[float], target_deg: Sequence[float]) -> float:
    """Return by how much the joints are off that is off most."""
    return farthest_off(stands_deg[: protocol.JOINTS], target_deg[: protocol.JOINTS])
