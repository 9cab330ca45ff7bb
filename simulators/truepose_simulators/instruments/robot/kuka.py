"""A controller of KUKA behind a variable proxy: its variables, and TRUEPOSE, our program on it."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.kuka_variable_proxy import protocol
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, check_range, nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import ArmStopped, RobotHangs, RobotRefuses
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.clients import Heartbeat, say_to_client
from truepose_simulators.instruments.robot.kinematics import flange_angles_deg
from truepose_simulators.physics.rigid import FloatArray

_PERCENT = 100.0
_NO_LIMIT = 1e12  # of a speed, in any unit
_ORIGIN = np.zeros(3)


class TruePose:
    """The program and its variables."""

    def __init__(self, cell: Cell) -> None:
        self.state = protocol.ProgramState(0, 0, 0, 0)
        self.target_deg: tuple[float, ...] = (0.0,) * 12
        self.percent = 1
        self.most_override = 1
        self.beat = 0
        self.override = 100  # of the controller, as set on its pendant
        self.stopped = False  # by a stop of the arm, before somebody starts it again
        self._cell = cell
        self._heartbeat = Heartbeat(cell, lambda: self.beat, silence_s=protocol.SILENCE_S)
        self._number = 0
        self._moving: asyncio.Task[None] | None = None

    @property
    def number(self) -> int:
        """Number of the motion that was ordered last."""
        return self._number

    @number.setter
    def number(self, number: int) -> None:
        self._number = number
        if self.state.begun != number and not self.state.moves and not self.stopped:
            self.state = replace(self.state, begun=number)
            self._moving = asyncio.create_task(self._carry_out())

    def start_again(self) -> None:
        """Do what somebody does after a stop; a motion that was under way is not gone on with."""
        self.stopped = False
        self._number = self.state.begun
        self.state = replace(self.state, given_up=self.state.begun)

    async def _carry_out(self) -> None:
        number = self.state.begun
        try:
            check_range(self._cell.plant.arm, self._target_rad())
            if await self._heartbeat.begins():
                await self._move(number)
            else:
                self.state = replace(self.state, given_up=number)
        except TargetOutOfRangeError:
            self.state = replace(self.state, refused=number)
        except ArmStoppedError:
            self.stopped = True

    async def _move(self, number: int) -> None:
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise TargetOutOfRangeError("the target was refused")
        share = self.percent / _PERCENT * min(self.override, self.most_override) / _PERCENT
        limits = SpeedLimits(_NO_LIMIT, _NO_LIMIT, joint_share=share)
        motion = self._cell.set_off([self._target_rad()], limits, _ORIGIN)
        if not await self._heartbeat.lasts(motion.duration_s):
            self._cell.halt_robot()
            self.state = replace(self.state, given_up=number)
        elif not isinstance(fault, RobotHangs):
            self.state = replace(self.state, arrived=number)

    def _target_rad(self) -> FloatArray:
        target: FloatArray = np.radians(self.target_deg[: self._cell.plant.arm.n_joints])
        return target


_AXES = 12  # that are stated of every arm
_MS_PER_S = 1000.0


class Variables:
    """What can be read and written by name; capitals do not matter."""

    def __init__(self, cell: Cell, server: str | None = None) -> None:
        self._cell = cell
        self.program = TruePose(cell)
        self._readable: Mapping[str, Callable[[], str]] = {
            protocol.Variable.PING: lambda: "PONG",
            protocol.Variable.AXES: self._axes,
            "$AXIS_ACT_MEAS": self._axes,
            "$POS_ACT": self._position,
            protocol.Variable.OVERRIDE: lambda: str(self.program.override),
            protocol.Variable.PROGRAM_STATE: self._program_state,
            "$PRO_STATE": self._program_state,
            protocol.Variable.MODE: lambda: "#EX",
            protocol.Variable.DRIVES: lambda: "FALSE" if self._arm_is_stopped() else "TRUE",
            protocol.Variable.SERIAL: lambda: cell.robot_serial,
            protocol.Variable.MODEL: lambda: f'"#{cell.plant.arm.model}"',
            protocol.Variable.SOFTWARE: lambda: '"KS V8.3.0 (simulated)"',
            "$ROBNAME[]": lambda: '"truepose"',
            "$ROB_TIMER": lambda: str(round(_MS_PER_S * asyncio.get_running_loop().time())),
        }
        self._writable: Mapping[str, Callable[[str], None]] = {protocol.Variable.OVERRIDE: self._set_override}
        if (server or cell.scenario.arm.server) == "truepose":
            self._load_program()

    def answer(self, request: protocol.Request) -> protocol.Answer:
        """Read or write a variable; one that is not there is read as nothing, as the public server does."""
        name = request.name.strip().upper()
        if request.value is None:
            read = self._readable.get(name)
            return protocol.Answer(
                request.number, protocol.Mode.READ, "" if read is None else read(), done=True
            )
        return protocol.Answer(
            request.number, protocol.Mode.WRITE, request.value, self._written(name, request.value)
        )

    def _load_program(self) -> None:
        program = self.program
        self._readable = {
            **self._readable,
            protocol.Variable.STATE: lambda: protocol.encode_state(program.state),
            protocol.Variable.TARGET: lambda: protocol.encode_axes(program.target_deg, "E6AXIS"),
            protocol.Variable.PERCENT: lambda: str(program.percent),
            protocol.Variable.MOST_OVERRIDE: lambda: str(program.most_override),
            protocol.Variable.NUMBER: lambda: str(program.number),
            protocol.Variable.BEAT: lambda: str(program.beat),
        }
        self._writable = {
            **self._writable,
            protocol.Variable.TARGET: self._set_target,
            protocol.Variable.PERCENT: lambda value: setattr(
                program, "percent", protocol.decode_count(value)
            ),
            protocol.Variable.MOST_OVERRIDE: lambda value: setattr(
                program, "most_override", protocol.decode_count(value)
            ),
            protocol.Variable.NUMBER: lambda value: setattr(program, "number", protocol.decode_count(value)),
            protocol.Variable.BEAT: lambda value: setattr(program, "beat", protocol.decode_count(value)),
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
        shown = np.degrees(self._cell.joints_rad).tolist()  # the controller counts as the drawing does
        return protocol.encode_axes([*shown, *(0.0 for _ in range(_AXES - len(shown)))], "E6AXIS")

    def _position(self) -> str:
        flange = nominal_flange(self._cell.plant.arm, self._cell.joints_rad[np.newaxis])[0]
        c_deg, b_deg, a_deg = flange_angles_deg(flange[:3, :3])
        numbers = dict(zip("XYZABC", (*flange[:3, 3].tolist(), a_deg, b_deg, c_deg), strict=True))
        further = {f"E{axis}": 0.0 for axis in range(1, 7)}
        texts = {name: protocol.encode_real(value) for name, value in (numbers | further).items()}
        # Postures are not told apart here: every one is stated as this.
        named = {**{name: texts[name] for name in "XYZABC"}, "S": "2", "T": "35"}
        return protocol.encode_aggregate({**named, **{name: texts[name] for name in further}}, "E6POS")

    def _program_state(self) -> str:
        if self.program.stopped and not self._arm_is_stopped():
            self.program.start_again()
        return "#P_STOP" if self._arm_is_stopped() else protocol.ACTIVE

    def _arm_is_stopped(self) -> bool:
        return self._cell.faults.holds(ArmStopped, self._cell.clock.now_s)

    def _set_override(self, value: str) -> None:
        self.program.override = min(protocol.decode_count(value), 100)

    def _set_target(self, value: str) -> None:
        self.program.target_deg = protocol.decode_axes(value)


_CHUNK_BYTES = 2048
_HANGS_UP_AFTER_S = 30.0  # of silence, wall time


def proxy_endpoint(cell: Cell, variables: Variables) -> Endpoint:
    """Build the proxy of a cell's robot."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        requests = protocol.RequestReader()
        with contextlib.suppress(protocol.ProxyProtocolError, TimeoutError):  # it hangs up
            while data := await asyncio.wait_for(reader.read(_CHUNK_BYTES), _HANGS_UP_AFTER_S):
                requests.receive_data(data)
                while (request := requests.next_message()) is not None:
                    await say_to_client(cell, writer, protocol.encode_answer(variables.answer(request)))

    return Endpoint("robot", "kuka_variable_proxy", serve)
