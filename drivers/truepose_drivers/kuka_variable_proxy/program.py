"""Our program on the controller, met through its variables: orders, beats, and what became of them."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose_drivers.arms.joint_counting import Angles
from truepose_drivers.arms.targets import farthest_off
from truepose_drivers.errors import (
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.kuka_variable_proxy.protocol.frames import ProxyProtocolError
from truepose_drivers.kuka_variable_proxy.protocol.variables import (
    ACTIVE,
    BEAT_S,
    JOINTS,
    SILENCE_S,
    STEP_DEG,
    ProgramState,
    Variable,
    decode_axes,
    decode_count,
    decode_state,
    decode_text,
    encode_axes,
    following,
)
from truepose_drivers.kuka_variable_proxy.proxy import VariableProxy

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

    async def ready(self) -> ProgramState:
        """Return the state of the program, which waits for an order; raises NotInitialisedError."""
        if await self._proxy.read(Variable.PROGRAM_STATE, decode_text) != ACTIVE:
            raise NotInitialisedError(f"no program runs on the robot: clear its messages, {_START}")
        if await self._proxy.read(Variable.DRIVES, decode_text) != "TRUE":
            raise NotInitialisedError(f"the robot's drives are not ready: switch them on, {_START}")
        try:
            state = await self._proxy.read(Variable.STATE, decode_state)
        except DeviceRefusedError as error:
            raise NotInitialisedError(
                f"the program TRUEPOSE is not on the controller: load it, {_START}"
            ) from error
        if state.moves:
            raise NotInitialisedError("the robot still moves, or stops on its way: wait for it, then confirm")
        return state

    async def give(self, order: Order) -> None:
        """Write what a motion shall be, and see that it stands there."""
        await self._proxy.write(Variable.TARGET, encode_axes(order.axes_deg))
        await self._proxy.write(Variable.PERCENT, str(order.percent))
        await self._proxy.write(Variable.MOST_OVERRIDE, str(order.override_percent))
        stands_deg = await self._proxy.read(Variable.TARGET, decode_axes)
        percent = await self._proxy.read(Variable.PERCENT, decode_count)
        override = await self._proxy.read(Variable.MOST_OVERRIDE, decode_count)
        speeds = (percent, override) == (order.percent, order.override_percent)
        if not speeds or off_deg(stands_deg, order.axes_deg) > STEP_DEG:
            await self._proxy.close()
            raise ProxyProtocolError(
                "the robot does not keep what is written to the variables of TRUEPOSE: see that no other"
                " program writes them, then connect again"
            )

    async def carry_out(self, number: int, longest_s: float) -> None:
        """Have the order carried out under a number, and give beats until the arm has arrived."""
        await self._proxy.write(Variable.NUMBER, str(number))
        ordered_s = _now_s()
        while not await self._arrived(number, _now_s() - ordered_s):
            if _now_s() - ordered_s > longest_s:
                await self._proxy.close()
                raise NoReplyError(
                    "the robot has not arrived in time: look at its pendant for a paused program, then"
                    " connect again"
                )
            await asyncio.sleep(BEAT_S)

    async def _arrived(self, number: int, since_s: float) -> bool:
        self._beat = following(self._beat)
        await self._proxy.write(Variable.BEAT, str(self._beat))
        state = await self._proxy.read(Variable.STATE, decode_state)
        if state.refused == number:
            raise TargetRefusedError("the robot refused it as out of the ranges of its axes")
        if state.given_up == number:
            raise ConnectionLostError(
                f"the robot stopped on its way, having heard nothing for {SILENCE_S:g} s: check the network,"
                " then confirm before anything moves"
            )
        if state.begun != number and since_s > _BEGINS_WITHIN_S:
            raise NotInitialisedError(f"the robot did not begin the motion: {_START}")
        if state.arrived != number:
            await self._require_running()
        return state.arrived == number

    async def _require_running(self) -> None:
        state = await self._proxy.read(Variable.PROGRAM_STATE, decode_text)
        if state != ACTIVE:
            raise NotInitialisedError(
                f"the robot stopped on its way ({state}): look at the messages on its pendant, reset"
                f" TRUEPOSE, {_START}"
            )


def off_deg(stands_deg: Sequence[float], target_deg: Sequence[float]) -> float:
    """Return by how much the joints are off that is off most."""
    return farthest_off(stands_deg[:JOINTS], target_deg[:JOINTS])


def _now_s() -> float:
    return asyncio.get_running_loop().time()
