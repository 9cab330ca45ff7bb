"""A controller of ABB: open_abb's motion server, as its RAPID program behaves, and its logger.

Motion errors are not reported: the RAPID program stops, and the client sees no reply ("hang") or loses its
connection ("drop"), as the scenario says. Whoever stands beside the robot restarts the program when the
client has gone. Straight lines (MoveL) and arcs are followed in steps of the joints; external axes have no
mechanics.

After a client leaves, the real program closes its sockets and needs half a second before it accepts again.
A second client is let in by the operating system but hears nothing, until the first one leaves and takes
the server socket with it.
"""

import asyncio
import math
import time
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from truepose_drivers.abb_open_abb import protocol
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError, SimulatorError
from truepose_simulators.faults.kinds import LineStalls, RobotHangs, RobotRefuses
from truepose_simulators.instruments.endpoint import Endpoint, write_with_stall
from truepose_simulators.instruments.robot.clients import (
    AlwaysThere,
    Client,
    ClientMonitor,
    ProgramStoppedError,
    one_client_endpoint,
    rest_after,
    until_client_leaves,
    while_listening,
)
from truepose_simulators.instruments.robot.kinematics import UnreachableError, reach, straight_line
from truepose_simulators.physics.rigid import FloatArray, from_quaternion, inverse, motion, to_quaternion

_BUFFER_POSES = 512
_NO_AXIS = 9e9  # RAPID's value of an external axis that is not connected
_ROBOTWARE = "5.61.0100"

# Numbers of parameters that the program accepts.
_COUNTS: Mapping[int, tuple[int, ...]] = {
    protocol.Code.PING: (0,),
    protocol.Code.MOVE_LINEAR: (7,),
    protocol.Code.MOVE_JOINTS: (6,),
    protocol.Code.GET_POSE: (0,),
    protocol.Code.GET_JOINTS: (0,),
    protocol.Code.GET_EXTERNAL_AXES: (0,),
    protocol.Code.SET_TOOL: (7,),
    protocol.Code.SET_WORK_OBJECT: (7,),
    protocol.Code.SET_SPEED: (2, 4),
    protocol.Code.SET_ZONE: (4,),
    protocol.Code.BUFFER_ADD: (7,),
    protocol.Code.BUFFER_CLEAR: (0,),
    protocol.Code.BUFFER_LENGTH: (0,),
    protocol.Code.BUFFER_RUN: (0,),
    protocol.Code.MOVE_EXTERNAL_AXES: (6,),
    protocol.Code.SET_CIRCLE_POINT: (7,),
    protocol.Code.MOVE_CIRCLE: (7,),
    protocol.Code.CONTROLLER_INFO: (0,),
}
# What our own program has beside these.
_OWN_COUNTS: Mapping[int, tuple[int, ...]] = {protocol.Code.GET_SPEED: (0,), protocol.Code.WATCH: (1,)}
_BEAT = protocol.encode_request(protocol.Code.BEAT)
_LOOK_S = 0.1  # between two looks of our program at whether its client is still there
_ANGLE_DECIMALS = {"stock": 2, "truepose": 5}


class ProgramState(Protocol):
    """Whether the controller runs its program; others may stop it."""

    @property
    def runs(self) -> bool:
        """Whether it runs."""
        ...

    @property
    def speed_percent(self) -> float:
        """Speed override."""
        ...

    def restart(self) -> None:
        """Run it from its beginning, as far as nothing holds the arm."""
        ...


class AlwaysRuns:
    """A program that nobody else can stop."""

    runs = True
    speed_percent = 100.0

    def restart(self) -> None:
        """Do nothing: it runs."""


class InvalidPoseError(SimulatorError):
    """A pose whose quaternion has no length."""


class MotionProgram:
    """The RAPID program: its variables and what each code does."""

    def __init__(self, cell: Cell, controller: ProgramState | None = None) -> None:
        self._cell = cell
        self._controller = controller or AlwaysRuns()
        self.restart()

    def restart(self) -> None:
        """Begin anew, as somebody starts a stopped program; variables outlive clients but not this."""
        self._controller.restart()
        self._tool = np.eye(4)
        self._work_object = np.eye(4)
        self._limits = SpeedLimits()
        self._external_axes = [_NO_AXIS] * 6
        self._circle_point: FloatArray | None = None
        self._buffer: list[tuple[FloatArray, SpeedLimits]] = []
        self._last_code = 0
        self.forget_client()

    @property
    def is_ours(self) -> bool:
        """Whether the program is our own, which can watch its client."""
        return self._cell.scenario.arm.server == "truepose"

    def forget_client(self) -> None:
        """Watch nobody: a client that wants to be watched says so."""
        self._watched_s = 0.0
        self._client: Client = AlwaysThere()

    async def answer(self, data: bytes, client: Client | None = None) -> bytes | None:
        """Carry out what one receive delivered and return the reply, None for the wish to close (code 99).

        Our program replies nothing to a beat. Raises ProgramStoppedError where the real one would stop.
        """
        self._client = client or AlwaysThere()
        while self.is_ours and data.startswith(_BEAT):  # sent before the end of a motion was heard of
            data = data[len(_BEAT) :]
            if not data:
                return b""
        try:
            request = protocol.decode_request(data)
        except protocol.OpenAbbProtocolError:
            # The program keeps the code of the message before, and says that one is bad.
            return protocol.encode_reply(protocol.Reply(self._last_code, protocol.ReplyStatus.BAD_MESSAGE))
        self._last_code = request.code
        if request.code == protocol.Code.CLOSE:
            return None
        if len(request.values) not in self._counts(request.code):
            return protocol.encode_reply(protocol.Reply(request.code, protocol.ReplyStatus.BAD_MESSAGE))
        try:
            text = await self._carry_out(request)
        except (TargetOutOfRangeError, UnreachableError, InvalidPoseError, ArmStoppedError) as error:
            raise self._stopped(str(error)) from error
        return protocol.encode_reply(protocol.Reply(request.code, protocol.ReplyStatus.OK, text))

    def _counts(self, code: int) -> tuple[int, ...]:
        own = _OWN_COUNTS.get(code, ()) if self.is_ours else ()
        return _COUNTS.get(code, own)

    async def _carry_out(self, request: protocol.Request) -> str:
        values = np.array(request.values)
        match request.code:
            case protocol.Code.MOVE_JOINTS:
                await self._move([np.radians(values)], self._limits)
            case protocol.Code.MOVE_LINEAR:
                await self._move_through([_pose(values)], self._limits)
            case protocol.Code.MOVE_CIRCLE:
                await self._move_circle(_pose(values))
            case protocol.Code.BUFFER_RUN:
                for pose, limits in self._buffer:
                    await self._move_through([pose], limits)
            case _:
                self._set(request.code, values)
                return self._report(request.code)
        return ""

    def _report(self, code: int) -> str:
        match code:
            case protocol.Code.GET_POSE:
                numbers = self.pose()
                position = [protocol.rapid_number(value, 2) for value in numbers[:3]]
                return " ".join([*position, *(protocol.rapid_number(value, 3) for value in numbers[3:])])
            case protocol.Code.GET_JOINTS:
                decimals = _ANGLE_DECIMALS[self._cell.scenario.arm.server]
                return " ".join(
                    protocol.rapid_number(float(angle), decimals) for angle in np.degrees(self.joints())
                )
            case protocol.Code.GET_SPEED:
                turning = math.degrees(self._limits.orientation_rad_s)
                return (
                    f"{protocol.rapid_number(self._limits.tool_mm_s, 2)} {protocol.rapid_number(turning, 2)}"
                )
            case protocol.Code.GET_EXTERNAL_AXES:
                return " ".join(protocol.rapid_number(value, 2)[:8] for value in self._external_axes)
            case protocol.Code.BUFFER_LENGTH:
                return str(len(self._buffer))
            case protocol.Code.CONTROLLER_INFO:
                serial = self._cell.faults.serial("robot", f"SIM-{self._cell.seed}", self._cell.clock.now_s)
                own = f"*{protocol.OUR_SERVER}" if self.is_ours else ""
                return f"{serial}*{_ROBOTWARE}*{self._cell.plant.arm.model}{own}"
        return ""

    def _set(self, code: int, values: FloatArray) -> None:
        match code:
            case protocol.Code.SET_TOOL:
                self._tool = _pose(values)
            case protocol.Code.SET_WORK_OBJECT:
                self._work_object = _pose(values)
            case protocol.Code.SET_SPEED:
                self._limits = SpeedLimits(float(values[0]), math.radians(values[1]))
            case protocol.Code.WATCH:
                self._watched_s = float(values[0])
            case protocol.Code.MOVE_EXTERNAL_AXES:
                self._external_axes = values.tolist()
            case protocol.Code.SET_CIRCLE_POINT:
                self._circle_point = _pose(values)
            case protocol.Code.BUFFER_ADD if len(self._buffer) < _BUFFER_POSES:
                self._buffer.append((_pose(values), self._limits))
            case protocol.Code.BUFFER_CLEAR:
                self._buffer.clear()

    async def _move_circle(self, end: FloatArray) -> None:
        if self._circle_point is None:
            raise self._stopped("no point of the circle was set")
        # The measured stops are what counts: the arc is replaced by its two chords.
        await self._move_through([self._circle_point, end], self._limits)

    async def _move_through(self, poses: list[FloatArray], limits: SpeedLimits) -> None:
        """Follow straight lines of the tool centre point."""
        waypoints: list[FloatArray] = []
        joints = self._cell.robot.target_rad
        for pose in poses:
            target = self._work_object @ pose @ inverse(self._tool)
            for frame in straight_line(nominal_flange(self._cell.plant.arm, joints[np.newaxis])[0], target):
                joints = reach(self._cell.plant.arm, frame, joints)
                waypoints.append(joints)
        await self._move(waypoints, limits)

    async def _move(self, waypoints: list[FloatArray], limits: SpeedLimits) -> None:
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise self._stopped("the target was refused")
        if limits.tool_mm_s <= 0.0 or limits.orientation_rad_s <= 0.0:
            raise self._stopped("a speed must be above 0")
        share = self._controller.speed_percent / 100.0
        if not self._controller.runs or share <= 0.0:
            raise self._stopped("the program stands, or its speed override at 0 %")
        slowed = SpeedLimits(limits.tool_mm_s * share, limits.orientation_rad_s * share, joint_share=share)
        await self._rest_after(self._cell.set_off(waypoints, slowed, self._tool[:3, 3]).duration_s)
        if not self._controller.runs:
            raise self._stopped("the program was stopped on the way")
        if isinstance(fault, RobotHangs):
            raise ProgramStoppedError("the reply got lost", drops=False)

    async def _rest_after(self, duration_s: float) -> None:
        """Wait for the end of a motion; a watched one is given up when its client falls silent."""
        await rest_after(self._cell, duration_s, self._client, watched_s=self._watched_s, look_s=_LOOK_S)

    def _stopped(self, reason: str) -> ProgramStoppedError:
        return ProgramStoppedError(reason, drops=self._cell.scenario.arm.refusal == "drop")

    def pose(self) -> list[float]:
        """Return x y z [mm] and the quaternion, w first, of the present tool in the present work object."""
        flange = nominal_flange(self._cell.plant.arm, self.joints()[np.newaxis])[0]
        frame = inverse(self._work_object) @ flange @ self._tool
        return [*frame[:3, 3].tolist(), *to_quaternion(frame[:3, :3]).tolist()]

    def joints(self) -> FloatArray:
        """Return the joint angles now, shape (6,) [rad]."""
        return self._cell.robot.motion.joints_at(self._cell.clock.now_s)


def _pose(values: FloatArray) -> FloatArray:
    """Placement from x y z [mm] and a quaternion, w first; raises InvalidPoseError."""
    if not np.any(values[3:]):
        raise InvalidPoseError("a quaternion of length 0 is no orientation")
    return motion(values[:3], from_quaternion(values[3:]))


_LOG_PERIOD_S = 0.1  # of a virtual controller
_CHUNK_BYTES = 4096


def robot_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the motion server of a cell's robot."""

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.forget_client()
        while data := await reader.read(_CHUNK_BYTES):
            try:
                reply = await _answer(program, data, reader, cell)
            except ProgramStoppedError as stop:
                if not stop.drops:
                    await until_client_leaves(reader)
                program.restart()
                return
            if reply is None:
                return
            if cell.faults.holds(LineStalls, cell.clock.now_s):
                await write_with_stall(writer, reply)
            else:
                writer.write(reply)
            await writer.drain()

    return one_client_endpoint("robot", "open_abb", attend, cell)


async def _answer(
    program: MotionProgram, data: bytes, reader: asyncio.StreamReader, cell: Cell
) -> bytes | None:
    """Have the program answer; our own listens for its client meanwhile, open_abb's hears nothing."""
    if not program.is_ours:
        return await program.answer(data)
    ear = ClientMonitor(cell)
    return await while_listening(program.answer(data, ear), ear, reader)


def logger_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the logger of a cell's robot: poses and joint angles in turn, as long as somebody listens."""
    date, clock_time = time.strftime("%Y-%m-%d"), time.strftime("%H:%M:%S")

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        gone = asyncio.ensure_future(until_client_leaves(reader))
        kind = 0
        try:
            while not gone.done():
                elapsed_s = cell.clock.now_s
                numbers = program.pose() if kind == 0 else np.degrees(program.joints()).tolist()
                writer.write(
                    protocol.encode_log_line(
                        protocol.LogLine(kind, date, clock_time, elapsed_s, tuple(numbers))
                    )
                )
                await writer.drain()
                kind = 1 - kind
                # A stream cannot run in cell time that stands still: its period is wall time.
                await asyncio.wait([gone], timeout=_LOG_PERIOD_S)
        finally:
            gone.cancel()

    return one_client_endpoint("robot-log", "open_abb_log", attend, cell)
