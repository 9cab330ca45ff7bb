"""A controller of Universal Robots: registers, modes, and the scripts that it runs.

There is no interpreter: the driver's program is known by its text, and what it does is written here again.
Accelerations are not modelled, and a `movej` of others goes as fast as the joints can.
"""

import asyncio
import math
import re
from collections.abc import Callable, Mapping

import numpy as np

from truepose_drivers.universal_robots.script import (
    ARRIVED,
    BEGUN,
    GIVEN_UP,
    JOINTS,
    PROGRAM,
    SILENCE_S,
    Order,
    RobotMode,
    RuntimeState,
    SafetyMode,
    obstacle,
    order_in,
)
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import EmergencyStop, ProtectiveStop, RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.clients import Heartbeat
from truepose_simulators.physics.rigid import FloatArray, to_rotation_vector

SOFTWARE = (3, 15, 8, 106339)  # of the CB series
_REGISTERS = 48  # 0 to 23 for fieldbuses, 24 to 47 for RTDE clients
_TYPES = {"int": "INT32", "double": "DOUBLE"}
_MM_PER_M = 1000.0
_READABLE: Mapping[str, str] = {
    "timestamp": "DOUBLE",
    "target_q": "VECTOR6D",
    "actual_q": "VECTOR6D",
    "actual_TCP_pose": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
    "runtime_state": "UINT32",
}
_INPUT_REGISTERS = {
    f"input_{kind}_register_{at}": _TYPES[kind] for kind in _TYPES for at in range(_REGISTERS)
}
_OUTPUT_REGISTERS = {
    f"output_{kind}_register_{at}": _TYPES[kind] for kind in _TYPES for at in range(_REGISTERS)
}

WRITABLE: Mapping[str, str] = _INPUT_REGISTERS
READABLE: Mapping[str, str] = {**_READABLE, **_INPUT_REGISTERS, **_OUTPUT_REGISTERS}


class Controller:
    """One controller; its arm is that of the cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.registers: dict[str, tuple[float, ...]] = dict.fromkeys((*WRITABLE, *_OUTPUT_REGISTERS), (0.0,))
        self.written_by_others: set[str] = set()  # inputs that some client has taken
        self.robot_mode = RobotMode.RUNNING
        self.safety_mode = SafetyMode.NORMAL
        self.runtime_state = RuntimeState.STOPPED
        self.clock_stands = False  # states are sent, and none is newer
        self.listeners: list[Callable[[str], None]] = []
        self._timestamp_s = 0.0

    def value(self, name: str) -> tuple[float, ...]:
        """Return a field that can be read."""
        match name:
            case "timestamp":
                return (self._now_s(),)
            case "target_q":
                return tuple(self.cell.robot.target_rad.tolist())
            case "actual_q":
                return tuple(self.cell.joints_rad.tolist())
            case "actual_TCP_pose":
                return self._flange()
            case "safety_mode":
                return (int(self.safety()),)
            case "robot_mode" | "runtime_state":
                return (int(getattr(self, name)),)
        return self.registers[name]

    def safety(self) -> SafetyMode:
        """Return what the safety system allows now."""
        now_s = self.cell.clock.now_s
        if self.cell.faults.holds(EmergencyStop, now_s):
            return SafetyMode.ROBOT_EMERGENCY_STOP
        if self.cell.faults.holds(ProtectiveStop, now_s):
            return SafetyMode.PROTECTIVE_STOP
        return self.safety_mode

    def tell(self, message: str) -> None:
        """Say something to whoever listens."""
        for listener in self.listeners:
            listener(message)

    def _now_s(self) -> float:
        # A state is stamped with the controller's time, which runs on where cell time stands still.
        if not self.clock_stands:
            self._timestamp_s = asyncio.get_running_loop().time()
        return self._timestamp_s

    def _flange(self) -> tuple[float, ...]:
        frame = nominal_flange(self.cell.plant.arm, self.cell.joints_rad[np.newaxis])[0]
        return (*(frame[:3, 3] / _MM_PER_M).tolist(), *to_rotation_vector(frame[:3, :3]).tolist())


_AT_REST_S = 0.5  # which the maker's `is_steady` waits for
_MOVEJ = re.compile(r"movej\(\s*\[([^\]]*)\][^)]*\)")
_AS_FAST_AS_JOINTS = SpeedLimits(math.inf, math.inf)
_ORIGIN = np.zeros(3)


class Programs:
    """What the controller runs; a new program takes the place of the one before."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._cell = controller.cell
        self._heartbeat = Heartbeat(self._cell, lambda: self._order().beat, silence_s=SILENCE_S)
        self._running: asyncio.Task[None] | None = None

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
            if await self._heartbeat.begins():
                await self._carry_out(order)
            else:
                self._answer(GIVEN_UP, order.number)
        except (TargetOutOfRangeError, ArmStoppedError) as error:
            self._controller.tell(str(error))
        self._controller.runtime_state = RuntimeState.STOPPED

    async def _carry_out(self, order: Order) -> None:
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise TargetOutOfRangeError("the target was refused")
        limits = SpeedLimits(order.tool_speed_mm_s, order.turning_speed_rad_s)
        motion = self._cell.set_off([np.array(order.target_rad)], limits, _ORIGIN)
        if not await self._heartbeat.lasts(motion.duration_s + _AT_REST_S):
            self._cell.halt_robot()
            self._answer(GIVEN_UP, order.number)
            return
        if isinstance(fault, RobotHangs):
            await asyncio.Event().wait()
        self._answer(ARRIVED, order.number)

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
