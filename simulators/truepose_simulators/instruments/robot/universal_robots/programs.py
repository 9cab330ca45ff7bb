"""Scripts that the controller runs: the driver's program, and single `movej` and `stopj` of other clients.

There is no interpreter: the driver's program is known by its text, and what it does is written here again.
Accelerations are not modelled, and a `movej` of others goes as fast as the joints can.
"""

import asyncio
import math
import re

import numpy as np

from truepose_drivers.universal_robots.protocol.modes import RuntimeState, obstacle
from truepose_drivers.universal_robots.protocol.motion import (
    ARRIVED,
    BEGUN,
    GIVEN_UP,
    JOINTS,
    PROGRAM,
    SILENCE_S,
    Order,
    order_in,
)
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.universal_robots.controller import Controller
from truepose_simulators.physics.rigid import FloatArray

_LOOK_S = 0.05  # between two looks at the beat; the real program looks every step
_AT_REST_S = 0.5  # which the maker's `is_steady` waits for
_MOVEJ = re.compile(r"movej\(\s*\[([^\]]*)\][^)]*\)")
_AS_FAST_AS_JOINTS = SpeedLimits(math.inf, math.inf)
_ORIGIN = np.zeros(3)


class Programs:
    """What the controller runs; a new program takes the place of the one before."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._cell = controller.cell
        self._running: asyncio.Task[None] | None = None
        controller.on_stop = self.stop

    def stop(self) -> None:
        """End the program; the arm is left to whoever asks."""
        if self._running is not None:
            self._running.cancel()
        self._controller.runtime_state = RuntimeState.STOPPED

    def start(self, script: str) -> None:
        """Run a script; one that is none of those above is told of and not run."""
        if obstacle(self._controller.robot_mode, self._controller.safety()) is not None:
            return
        self.stop()
        self._cell.halt_robot()
        if script.strip() == PROGRAM.strip():
            self._running = asyncio.create_task(self._run_ours())
        elif (motion := _MOVEJ.fullmatch(script.strip())) is not None:
            self._running = asyncio.create_task(self._run_movej(motion[1]))
        elif not script.strip().startswith("stopj("):
            self._controller.tell(f"script not understood: {script[:60]!r}")

    async def _run_ours(self) -> None:
        order = self._order()
        self._controller.runtime_state = RuntimeState.PLAYING
        self._answer(BEGUN, order.number)
        try:
            if await self._heard_first(order.beat):
                await self._carry_out(order)
            else:
                self._answer(GIVEN_UP, order.number)
        except (TargetOutOfRangeError, ArmStoppedError) as error:
            self._controller.tell(str(error))
        self._controller.runtime_state = RuntimeState.STOPPED

    async def _heard_first(self, beat: int) -> bool:
        """Whether somebody gives a beat; where time costs nothing nobody is late."""
        unheard_s = 0.0
        while self._cell.clock.waits and unheard_s < SILENCE_S:
            if self._order().beat != beat:
                return True
            await self._cell.clock.sleep(_LOOK_S)
            unheard_s += _LOOK_S
        return not self._cell.clock.waits

    async def _carry_out(self, order: Order) -> None:
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise TargetOutOfRangeError("the target was refused")
        limits = SpeedLimits(order.tool_speed_mm_s, order.turning_speed_rad_s)
        motion = self._cell.set_off([np.array(order.target_rad)], limits, _ORIGIN)
        if not await self._heard_for(motion.duration_s + _AT_REST_S):
            self._cell.halt_robot()
            self._answer(GIVEN_UP, order.number)
            return
        if isinstance(fault, RobotHangs):
            await asyncio.Event().wait()
        self._answer(ARRIVED, order.number)

    async def _heard_for(self, duration_s: float) -> bool:
        """Whether the beat goes on for so long; raises ArmStoppedError."""
        clock = self._cell.clock
        beat, unheard_s = self._order().beat, 0.0
        while clock.waits and duration_s > _LOOK_S:
            await self._cell.glide(_LOOK_S)
            duration_s -= _LOOK_S
            before, beat = beat, self._order().beat
            unheard_s = unheard_s + _LOOK_S if beat == before else 0.0
            if unheard_s >= SILENCE_S:
                return False
        await self._cell.glide(duration_s)
        return True

    async def _run_movej(self, joints: str) -> None:
        target = _numbers(joints)
        if target is None:
            self._controller.tell("movej needs six joint angles")
            return
        self._controller.runtime_state = RuntimeState.PLAYING
        try:
            await self._cell.move_robot([target], _AS_FAST_AS_JOINTS, _ORIGIN)
        except (TargetOutOfRangeError, ArmStoppedError) as error:
            self._controller.tell(str(error))
        self._controller.runtime_state = RuntimeState.STOPPED

    def _order(self) -> Order:
        return order_in(self._controller.registers)

    def _answer(self, register: str, number: int) -> None:
        self._controller.registers[register] = (number,)


def _numbers(text: str) -> FloatArray | None:
    try:
        numbers = np.array([float(word) for word in text.split(",")])
    except ValueError:
        return None
    return numbers if len(numbers) == JOINTS and np.isfinite(numbers).all() else None
