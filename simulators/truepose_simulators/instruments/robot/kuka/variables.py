"""The variables of the controller: system variables, and those of TRUEPOSE where it is loaded."""

import asyncio
from collections.abc import Callable, Mapping

import numpy as np

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.kuka_variable_proxy.protocol.frames import Answer, Mode, Request
from truepose_drivers.kuka_variable_proxy.protocol.variables import (
    ACTIVE,
    Variable,
    decode_axes,
    decode_count,
    encode_aggregate,
    encode_axes,
    encode_real,
    encode_state,
)
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import ArmStopped
from truepose_simulators.instruments.robot.fanuc_joints import flange_angles_deg
from truepose_simulators.instruments.robot.kuka.program import TruePose
from truepose_simulators.physics.rigid import FloatArray

_AXES = 12  # that are stated of every arm
_MS_PER_S = 1000.0


class Variables:
    """What can be read and written by name; capitals do not matter."""

    def __init__(self, cell: Cell, server: str | None = None) -> None:
        self._cell = cell
        self.program = TruePose(cell)
        self._readable: Mapping[str, Callable[[], str]] = {
            Variable.PING: lambda: "PONG",
            Variable.AXES: self._axes,
            "$AXIS_ACT_MEAS": self._axes,
            "$POS_ACT": self._position,
            Variable.OVERRIDE: lambda: str(self.program.override),
            Variable.PROGRAM_STATE: self._program_state,
            "$PRO_STATE": self._program_state,
            Variable.MODE: lambda: "#EX",
            Variable.DRIVES: lambda: "FALSE" if self._arm_is_stopped() else "TRUE",
            Variable.SERIAL: lambda: cell.faults.serial("robot", f"SIM-{cell.seed}", cell.clock.now_s),
            Variable.MODEL: lambda: f'"#{cell.plant.arm.model}"',
            Variable.SOFTWARE: lambda: '"KS V8.3.0 (simulated)"',
            "$ROBNAME[]": lambda: '"truepose"',
            "$ROB_TIMER": lambda: str(round(_MS_PER_S * asyncio.get_running_loop().time())),
        }
        self._writable: Mapping[str, Callable[[str], None]] = {Variable.OVERRIDE: self._set_override}
        if (server or cell.scenario.arm.server) == "truepose":
            self._load_program()

    def answer(self, request: Request) -> Answer:
        """Read or write a variable; one that is not there is read as nothing, as the public server does."""
        name = request.name.strip().upper()
        if request.value is None:
            read = self._readable.get(name)
            return Answer(request.number, Mode.READ, "" if read is None else read(), done=True)
        return Answer(request.number, Mode.WRITE, request.value, self._written(name, request.value))

    def joints(self) -> FloatArray:
        """Return the joint angles of the drawing now, shape (6,) [rad]; the controller counts alike."""
        return self._cell.robot.motion.joints_at(self._cell.clock.now_s)

    def _load_program(self) -> None:
        program = self.program
        self._readable = {
            **self._readable,
            Variable.STATE: lambda: encode_state(program.state),
            Variable.TARGET: lambda: encode_axes(program.target_deg, "E6AXIS"),
            Variable.PERCENT: lambda: str(program.percent),
            Variable.MOST_OVERRIDE: lambda: str(program.most_override),
            Variable.NUMBER: lambda: str(program.number),
            Variable.BEAT: lambda: str(program.beat),
        }
        self._writable = {
            **self._writable,
            Variable.TARGET: self._set_target,
            Variable.PERCENT: lambda value: setattr(program, "percent", decode_count(value)),
            Variable.MOST_OVERRIDE: lambda value: setattr(program, "most_override", decode_count(value)),
            Variable.NUMBER: lambda value: setattr(program, "number", decode_count(value)),
            Variable.BEAT: lambda value: setattr(program, "beat", decode_count(value)),
        }

    def _written(self, name: str, value: str) -> bool:
        write = self._writable.get(name)
        if write is None:
            return False
        try:
            write(value)
        except RemoteProtocolError:
            return False
        return True

    def _axes(self) -> str:
        shown = np.degrees(self.joints()).tolist()
        return encode_axes([*shown, *(0.0 for _ in range(_AXES - len(shown)))], "E6AXIS")

    def _position(self) -> str:
        flange = nominal_flange(self._cell.plant.arm, self.joints()[np.newaxis])[0]
        c_deg, b_deg, a_deg = flange_angles_deg(flange[:3, :3])
        numbers = dict(zip("XYZABC", (*flange[:3, 3].tolist(), a_deg, b_deg, c_deg), strict=True))
        further = {f"E{axis}": 0.0 for axis in range(1, 7)}
        texts = {name: encode_real(value) for name, value in (numbers | further).items()}
        # Postures are not told apart here: every one is stated as this.
        named = {**{name: texts[name] for name in "XYZABC"}, "S": "2", "T": "35"}
        return encode_aggregate({**named, **{name: texts[name] for name in further}}, "E6POS")

    def _program_state(self) -> str:
        if self.program.stopped and not self._arm_is_stopped():
            self.program.start_again()
        return "#P_STOP" if self._arm_is_stopped() else ACTIVE

    def _arm_is_stopped(self) -> bool:
        return self._cell.faults.holds(ArmStopped, self._cell.clock.now_s)

    def _set_override(self, value: str) -> None:
        self.program.override = min(decode_count(value), 100)

    def _set_target(self, value: str) -> None:
        self.program.target_deg = decode_axes(value)
