"""What the controller knows of itself: registers, modes, and the fields that RTDE has of them."""

import asyncio
from collections.abc import Callable, Mapping

import numpy as np

from truepose_drivers.universal_robots.protocol.modes import RobotMode, RuntimeState, SafetyMode
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import EmergencyStop, ProtectiveStop
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
        self.on_stop: Callable[[], None] = lambda: None  # of whatever program runs
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
                return tuple(self._joints().tolist())
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

    def stop(self, safety_mode: SafetyMode) -> None:
        """Stop the arm and the program, as a protective stop or an emergency stop does."""
        self.safety_mode = safety_mode
        self.on_stop()
        self.cell.halt_robot()

    def tell(self, message: str) -> None:
        """Say something to whoever listens."""
        for listener in self.listeners:
            listener(message)

    def _now_s(self) -> float:
        # A state is stamped with the controller's time, which runs on where cell time stands still.
        if not self.clock_stands:
            self._timestamp_s = asyncio.get_running_loop().time()
        return self._timestamp_s

    def _joints(self) -> FloatArray:
        return self.cell.robot.motion.joints_at(self.cell.clock.now_s)

    def _flange(self) -> tuple[float, ...]:
        frame = nominal_flange(self.cell.plant.arm, self._joints()[np.newaxis])[0]
        return (*(frame[:3, 3] / _MM_PER_M).tolist(), *to_rotation_vector(frame[:3, :3]).tolist())
