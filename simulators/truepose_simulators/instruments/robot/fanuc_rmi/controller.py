"""What the controller is, and its commands: they are carried out at once, while instructions wait."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import Kind, Packet, Status, encode_axes, encode_status, reply
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import ArmStopped
from truepose_simulators.instruments.robot.fanuc_rmi.registers import (
    Frames,
    RefusedError,
    Registers,
    fields_of,
    six_in,
)
from truepose_simulators.instruments.robot.kinematics import displayed_deg

Fields = Mapping[str, object]
_AXES = 9  # that are stated of every arm
_PAUSED = 2  # of a program
_MOMENT_S = 1e-3  # over which a speed is taken


class Controller:
    """One controller; its arm is that of the cell."""

    def __init__(self, cell: Cell, *, keeps_sequence: bool = False, strands: bool = False) -> None:
        self.cell = cell
        self.frames = Frames(cell.plant.arm)
        self.status = Status(
            servo_ready=True,
            pendant_on=False,
            running=False,
            single_step=False,
            next_sequence=1,
            override_percent=100,
        )
        self.shown_errors: list[str] = []
        self.clock_stands = False  # joints are stated, and none is newer
        self.on_abort: Callable[[], None] = lambda: None  # what its program does then
        self.paused = False
        self.on_pause: Callable[[], None] = lambda: None
        self.on_continue: Callable[[], None] = lambda: None
        self._keeps_sequence = keeps_sequence  # of instructions, as some controllers do until switched off
        self._strands = strands  # a session that dies leaves a program that only a person can delete
        self._stranded = False
        self._inputs: dict[int, int] = {}
        registers = Registers()
        self._time_ms = 0
        self._commands: dict[str, Callable[[Packet], Fields]] = {
            "FRC_Initialize": self._initialize,
            "FRC_Abort": self._abort,
            "FRC_Reset": self._reset,
            "FRC_Pause": self._pause,
            "FRC_Continue": self._continue,
            "FRC_GetStatus": self._stated_status,
            "FRC_GetExtStatus": self._extended_status,
            "FRC_ReadError": self._errors,
            "FRC_ReadJointAngles": self._joint_angles,
            "FRC_ReadCartesianPosition": self._position,
            "FRC_ReadTCPSpeed": self._tool_speed,
            "FRC_SetOverRide": self._set_override,
            "FRC_GetUFrameUTool": self._numbers,
            "FRC_SetUFrameUTool": self._set_numbers,
            "FRC_ReadUFrameData": lambda asked: self._read_frame(asked, "FrameNumber"),
            "FRC_WriteUFrameData": lambda asked: self._write_frame(asked, "FrameNumber"),
            "FRC_ReadUToolData": lambda asked: self._read_frame(asked, "ToolNumber"),
            "FRC_WriteUToolData": lambda asked: self._write_frame(asked, "ToolNumber"),
            "FRC_ReadDIN": self._input,
            "FRC_WriteDOUT": self._output,
            "FRC_ReadRegister": registers.number,
            "FRC_WriteRegister": registers.write_number,
            "FRC_ReadPositionRegister": registers.position,
            "FRC_WritePositionRegister": registers.write_position,
            "FRC_SetPayloadID": lambda _: {},
        }

    def answer(self, request: Packet) -> Packet:
        """Carry out a command and return the reply."""
        carry_out = self._commands.get(request.name)
        if request.kind is not Kind.COMMAND or carry_out is None:
            return Packet(Kind.COMMAND, "Unknown", {"ErrorID": protocol.UNKNOWN_COMMAND})
        try:
            return reply(request, fields=carry_out(request))
        except RefusedError as refusal:
            return reply(request, refusal.error)
        except RemoteProtocolError:
            return reply(request, protocol.BAD_VALUE)

    def lose_client(self) -> None:
        """Go on with what was sent: nobody said that the session ends."""
        self._stranded = self._strands and self.status.running

    def end(self) -> None:
        """End the program, and the arm's motion with it."""
        self.status = replace(self.status, running=False)
        self.on_abort()
        self.cell.halt_robot()

    def select(self, stated: Packet) -> None:
        """Make the frames active that a packet names, as far as it does; raises RefusedError."""
        user = stated.whole("UFrameNumber") if "UFrameNumber" in stated.fields else self.frames.user_number
        tool = stated.whole("UToolNumber") if "UToolNumber" in stated.fields else self.frames.tool_number
        if user not in self.frames.user:
            raise RefusedError(protocol.BAD_FRAME)
        if tool not in self.frames.tools:
            raise RefusedError(protocol.BAD_TOOL)
        self.frames.user_number, self.frames.tool_number = user, tool

    def _initialize(self, _: Packet) -> Fields:
        if self._stranded:
            raise RefusedError(protocol.PROGRAM_EXISTS)
        status = self._status()
        if status.running or status.pendant_on or not status.servo_ready or self.shown_errors:
            raise RefusedError(protocol.INVALID_STATE)
        sequence = self.status.next_sequence if self._keeps_sequence else 1
        self.status = replace(self.status, running=True, next_sequence=sequence)
        return {"GroupMask": 1}

    def _status(self) -> Status:
        stopped = self.cell.faults.holds(ArmStopped, self.cell.clock.now_s)
        return replace(self.status, servo_ready=self.status.servo_ready and not stopped)

    def _stated_status(self, _: Packet) -> Fields:
        return encode_status(self._status()) | ({"ProgramStatus": _PAUSED} if self.paused else {})

    def _abort(self, _: Packet) -> Fields:
        if not self.status.running:
            raise RefusedError(protocol.NOT_RUNNING)
        self.end()
        return {}

    def _reset(self, _: Packet) -> Fields:
        if self._status().servo_ready:
            self.shown_errors.clear()
        return {}

    def _pause(self, _: Packet) -> Fields:
        if not self.status.running:
            raise RefusedError(protocol.NOT_RUNNING)
        self.on_pause()
        return {}

    def _continue(self, _: Packet) -> Fields:
        self.on_continue()
        return {}

    def _extended_status(self, _: Packet) -> Fields:
        return {
            "InMotion": int(self.cell.robot_moves),
            "DrivesPowered": int(self._status().servo_ready),
            "GenOverride": self.status.override_percent,
            "ControlMode": "AUTO",
        }

    def _errors(self, asked: Packet) -> Fields:
        count = asked.whole("Count") if "Count" in asked.fields else 1
        if not 1 <= count <= len(protocol.ERROR_NAMES):
            raise RefusedError(protocol.BAD_VALUE)
        shown = self.shown_errors[-count:] or ["No Error"]
        return {"Count": len(shown), **dict(zip(protocol.ERROR_NAMES, reversed(shown), strict=False))}

    def _tagged(self) -> Fields:
        # Tags are of the controller's own time, which runs on where cell time stands still.
        if not self.clock_stands:
            self._time_ms = round(1000.0 * asyncio.get_running_loop().time())
        return {"TimeTag": self._time_ms}

    def _joint_angles(self, _: Packet) -> Fields:
        shown = [round(angle, 3) + 0.0 for angle in displayed_deg(self.cell.joints_rad).tolist()]
        axes = encode_axes([*shown, *(0.0 for _ in range(_AXES - len(shown)))])
        return {**self._tagged(), "JointAngle": axes}

    def _position(self, _: Packet) -> Fields:
        return {**self._tagged(), **self.frames.stated(self.frames.position(self.cell.joints_rad))}

    def _tool_speed(self, _: Packet) -> Fields:
        return {**self._tagged(), "Speed": round(self._travelled_mm() / _MOMENT_S, 3)}

    def _travelled_mm(self) -> float:
        if not self.cell.robot_moves:
            return 0.0
        now_s, motion = self.cell.clock.now_s, self.cell.robot.motion
        here, soon = (np.array(self.frames.position(motion.joints_at(s))) for s in (now_s, now_s + _MOMENT_S))
        return float(np.linalg.norm((soon - here)[:3]))

    def _set_override(self, asked: Packet) -> Fields:
        value = asked.whole("Value")
        if not 1 <= value <= 100:
            raise RefusedError(protocol.BAD_OVERRIDE)
        self.status = replace(self.status, override_percent=value)
        return {}

    def _numbers(self, _: Packet) -> Fields:
        return {"UFrameNumber": self.frames.user_number, "UToolNumber": self.frames.tool_number}

    def _set_numbers(self, asked: Packet) -> Fields:
        self.select(asked)
        return {}

    def _read_frame(self, asked: Packet, key: str) -> Fields:
        number = self._known(asked, key)
        return {key: number, "Frame": fields_of(self._taught(key)[number])}

    def _write_frame(self, asked: Packet, key: str) -> Fields:
        self._taught(key)[self._known(asked, key)] = six_in(asked.part("Frame"))
        return {}

    def _known(self, asked: Packet, key: str) -> int:
        number = asked.whole(key)
        if number not in self._taught(key) or number == 0:
            raise RefusedError(protocol.BAD_FRAME if key == "FrameNumber" else protocol.BAD_TOOL)
        return number

    def _taught(self, key: str) -> dict[int, tuple[float, ...]]:
        return self.frames.user if key == "FrameNumber" else self.frames.tools

    def _input(self, asked: Packet) -> Fields:
        port = asked.whole("PortNumber")
        return {"PortNumber": port, "PortValue": self._inputs.get(port, 0)}

    def _output(self, asked: Packet) -> Fields:
        self._inputs[asked.whole("PortNumber")] = int(asked.fields.get("PortValue") == "ON")
        return {}
