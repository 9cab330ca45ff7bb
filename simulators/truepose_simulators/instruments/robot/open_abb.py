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
from functools import partial

import numpy as np

from truepose_drivers.abb_open_abb import protocol
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError, SimulatorError
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController
from truepose_simulators.instruments.robot.clients import (
    AlwaysThere,
    Client,
    ProgramStoppedError,
    ServerProgram,
    one_client_endpoint,
    rest_after,
    say_to_client,
    until_client_leaves,
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


class InvalidPoseError(SimulatorError):
    """A pose whose quaternion has no length."""


class MotionProgram(ServerProgram):
    """The RAPID program: its variables and what each code does."""

    def __init__(self, cell: Cell, controller: AbbController | None = None) -> None:
        super().__init__(cell)
        self._controller = controller or AbbController(cell)
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
                decimals, joints_deg = _ANGLE_DECIMALS[self._server], np.degrees(self._cell.joints_rad)
                return " ".join(protocol.rapid_number(float(angle), decimals) for angle in joints_deg)
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
                own = f"*{protocol.OUR_SERVER}" if self.is_ours else ""
                return f"{self._cell.robot_serial}*{_ROBOTWARE}*{self._cell.plant.arm.model}{own}"
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
            raise self._stopped("the program is stopped, or its speed override is 0 %")
        slowed = SpeedLimits(limits.tool_mm_s * share, limits.orientation_rad_s * share, joint_share=share)
        duration_s = self._cell.set_off(waypoints, slowed, self._tool[:3, 3]).duration_s
        await rest_after(self._cell, duration_s, self._client, watched_s=self._watched_s, look_s=_LOOK_S)
        if not self._controller.runs:
            raise self._stopped("the program was stopped during the motion")
        if isinstance(fault, RobotHangs):
            raise ProgramStoppedError("the reply got lost", drops=False)

    def pose(self) -> list[float]:
        """Return x y z [mm] and the quaternion, w first, of the present tool in the present work object."""
        flange = nominal_flange(self._cell.plant.arm, self._cell.joints_rad[np.newaxis])[0]
        frame = inverse(self._work_object) @ flange @ self._tool
        return [*frame[:3, 3].tolist(), *to_quaternion(frame[:3, :3]).tolist()]


def _pose(values: FloatArray) -> FloatArray:
    """Placement from x y z [mm] and a quaternion, w first; raises InvalidPoseError."""
    if not np.any(values[3:]):
        raise InvalidPoseError("a quaternion of length 0 is not an orientation")
    return motion(values[:3], from_quaternion(values[3:]))


_LOG_PERIOD_S = 0.1  # of a virtual controller
_CHUNK_BYTES = 4096


def robot_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the motion server of a cell's robot."""

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.forget_client()
        while data := await reader.read(_CHUNK_BYTES):
            try:
                reply = await program.answer_meanwhile_heard(partial(program.answer, data), reader)
            except ProgramStoppedError as stop:
                if not stop.drops:
                    await until_client_leaves(reader)
                program.restart()
                return
            if reply is None:
                return
            await say_to_client(cell, writer, reply)

    return one_client_endpoint("robot", "open_abb", attend, cell)


def logger_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the logger of a cell's robot: poses and joint angles in turn, as long as somebody listens."""
    date, clock_time = time.strftime("%Y-%m-%d"), time.strftime("%H:%M:%S")

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        gone = asyncio.ensure_future(until_client_leaves(reader))
        kind = 0
        try:
            while not gone.done():
                elapsed_s = cell.clock.now_s
                numbers = program.pose() if kind == 0 else np.degrees(cell.joints_rad).tolist()
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
