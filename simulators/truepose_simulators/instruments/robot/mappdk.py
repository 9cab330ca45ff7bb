"""A controller of FANUC: the MAPPDK program, or our own, which does the same and watches its client.

A fault ends the program, and its sockets die with it ("drop"), or the client sees no reply ("hang"), as the
scenario says. Motions run in user frame and tool 8, which are nothing here. Outputs are kept, programs that
are called do nothing.

The logger has a task of its own on the controller, so that it tells joints while the arm moves.
"""

import asyncio
from functools import partial

import numpy as np

from truepose_drivers.fanuc_mappdk.protocol import (
    GREETING,
    Command,
    MappdkProtocolError,
    Motion,
    Reply,
    ReplyCode,
    Request,
    RequestReader,
    decode_motion,
    decode_request,
    decode_timed_motion,
    encode_identity,
    encode_joints,
    encode_reply,
)
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, check_range, nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.endpoint import Endpoint
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
from truepose_simulators.instruments.robot.kinematics import (
    UnreachableError,
    displayed_deg,
    flange_angles_deg,
    joints_rad,
    reach,
    rotation_of,
    straight_line,
    world,
)
from truepose_simulators.physics.rigid import FloatArray, inverse, motion

_SUCCESS = Reply(ReplyCode.OK, "success")
_OWN = frozenset({Command.IDENTITY, Command.WATCH, Command.BEAT, Command.MOVE_IN_TIME})
_DECIMALS = {"stock": 3, "truepose": 5}
_VERSION = "V7.70P"
_LOOK_S = 0.05  # between two looks of our program at whether its client is still there
_NO_LIMIT = 1e12  # of a speed, in any unit
_FULL_PERCENT = 100
_POSITION_WIDTH = 8


class MappdkProgram(ServerProgram):
    """A KAREL program: what each request does. The controller's `outputs` are those of all its programs."""

    def __init__(
        self, cell: Cell, server: str | None = None, *, outputs: dict[str, str] | None = None
    ) -> None:
        super().__init__(cell, server)
        self._outputs = {} if outputs is None else outputs

    async def answer(self, line: str, client: Client | None = None) -> bytes:
        """Carry out a line and return the reply, nothing to a beat.

        Raises ProgramStoppedError where the real one would stop.
        """
        self._client = client or AlwaysThere()
        request = decode_request(line)
        if self.is_ours and request.name == Command.BEAT:
            return b""
        try:
            return encode_reply(await self._carry_out(request))
        except MappdkProtocolError as error:  # its text is that of the reply
            return encode_reply(Reply(ReplyCode.ERROR, str(error)))
        except (TargetOutOfRangeError, UnreachableError):
            return encode_reply(Reply(ReplyCode.ERROR, "position-is-not-reachable"))
        except ArmStoppedError as error:
            raise self._stopped(str(error)) from error

    async def _carry_out(self, request: Request) -> Reply:
        if request.name in _OWN and not self.is_ours:
            return Reply(ReplyCode.ERROR, "wrong-command")
        match request.name:
            case Command.MOVE_TO_JOINTS:
                await self._move_to(_joints(decode_motion(request).values), decode_motion(request))
            case Command.MOVE_TO_POSE:
                wanted = decode_motion(request)
                await self._move_to(self._joints_at(wanted.values), wanted)
            case Command.MOVE_IN_TIME:
                timed = decode_timed_motion(request)
                limits = SpeedLimits(_NO_LIMIT, _NO_LIMIT, at_least_s=timed.duration_s)
                await self._move([_joints(timed.values)], limits)
            case _:
                return self._told(request)
        return _SUCCESS

    def _told(self, request: Request) -> Reply:
        match request.name:
            case Command.JOINTS:
                return encode_joints(displayed_deg(self._cell.joints_rad).tolist(), _DECIMALS[self._server])
            case Command.POSE:
                return self._pose()
            case Command.POWER:
                return Reply(ReplyCode.OK, "0.300000")
            case Command.IDENTITY:
                return encode_identity(self._cell.plant.arm.model, self._cell.robot_serial, _VERSION)
            case Command.WATCH:
                return self._watch(request)
            case Command.SET_ROBOT_OUTPUT | Command.SET_OUTPUT:
                return self._set_output(request)
            case Command.GET_ROBOT_OUTPUT | Command.GET_OUTPUT:
                return Reply(ReplyCode.OK, self._outputs.get(_output(request), "0"))
            case Command.CALL | Command.SET_SYSTEM_VARIABLE | Command.EXIT:
                return _SUCCESS
        return Reply(ReplyCode.ERROR, "wrong-command")

    def _watch(self, request: Request) -> Reply:
        if not request.fields or not request.fields[0].isdecimal():
            return Reply(ReplyCode.ERROR, "wrong-watch-value")
        self._watched_s = int(request.fields[0]) / 1000.0
        return _SUCCESS

    def _set_output(self, request: Request) -> Reply:
        kind = "rdo" if request.name == Command.SET_ROBOT_OUTPUT else "dout"
        if len(request.fields) != 2 or request.fields[1] not in {"true", "false"}:
            return Reply(ReplyCode.ERROR, f"wrong-{kind}-value")
        self._outputs[_output(request)] = "1" if request.fields[1] == "true" else "0"
        return _SUCCESS

    def _pose(self) -> Reply:
        frame = inverse(world(self._cell.plant.arm)) @ self._flange()
        values = [*frame[:3, 3].tolist(), *flange_angles_deg(frame[:3, :3])]
        texts = [
            # Adding 0.0 makes 0 of minus 0, which would be written as -0.000.
            f"{name}={round(value, 3) + 0.0:{_POSITION_WIDTH}.3f}"
            for name, value in zip("xyzwpr", values, strict=True)
        ]
        return Reply(ReplyCode.OK, ",".join(texts))

    async def _move_to(self, target: FloatArray, wanted: Motion) -> None:
        if wanted.speed < 1 or (wanted.speed > _FULL_PERCENT and not wanted.linear):
            raise self._stopped("a speed must be above 0, and a joint speed at most 100 %")
        check_range(self._cell.plant.arm, target)
        if wanted.linear:
            waypoints, frames = [], self._line_to(target)
            joints = self._cell.robot.target_rad
            for frame in frames:
                joints = reach(self._cell.plant.arm, frame, joints)
                waypoints.append(joints)
            await self._move(waypoints, SpeedLimits(float(wanted.speed), _NO_LIMIT))
            return
        share = wanted.speed / _FULL_PERCENT
        await self._move([target], SpeedLimits(_NO_LIMIT, _NO_LIMIT, joint_share=share))

    def _line_to(self, target: FloatArray) -> list[FloatArray]:
        return straight_line(self._flange(), nominal_flange(self._cell.plant.arm, target[np.newaxis])[0])

    def _joints_at(self, pose: tuple[float, ...]) -> FloatArray:
        """Return the joints of a pose x y z w p r; raises MappdkProtocolError, UnreachableError."""
        if len(pose) != 6:
            raise MappdkProtocolError("position-is-not-reachable")
        frame = motion(np.array(pose[:3]), rotation_of(*pose[3:]))
        return reach(self._cell.plant.arm, world(self._cell.plant.arm) @ frame, self._cell.robot.target_rad)

    async def _move(self, waypoints: list[FloatArray], limits: SpeedLimits) -> None:
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise self._stopped("a fault aborted the program")
        under_way = self._cell.set_off(waypoints, limits, np.zeros(3))
        await rest_after(
            self._cell, under_way.duration_s, self._client, watched_s=self._watched_s, look_s=_LOOK_S
        )
        if isinstance(fault, RobotHangs):
            raise ProgramStoppedError("the reply got lost", drops=False)

    def _flange(self) -> FloatArray:
        flange: FloatArray = nominal_flange(self._cell.plant.arm, self._cell.joints_rad[np.newaxis])[0]
        return flange


def _joints(values: tuple[float, ...]) -> FloatArray:
    if len(values) != 6:
        raise MappdkProtocolError("error-in-joint-values")
    return joints_rad(np.array(values))


def _output(request: Request) -> str:
    kind = "rdo" if request.name.endswith("rdo") else "dout"
    return f"{kind} {request.fields[0] if request.fields else ''}"


_CHUNK_BYTES = 4096


def mappdk_endpoint(cell: Cell, program: MappdkProgram) -> Endpoint:
    """Build the motion server of a cell's robot."""
    return _endpoint("robot", "mappdk", cell, program)


def mappdk_logger_endpoint(cell: Cell, program: MappdkProgram) -> Endpoint:
    """Build the second server, for questions while the first one moves."""
    return _endpoint("robot-logger", "mappdk_log", cell, program)


def _endpoint(device: str, protocol: str, cell: Cell, program: MappdkProgram) -> Endpoint:
    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.forget_client()
        writer.write(encode_reply(GREETING))
        await writer.drain()
        try:
            await _serve(cell, program, reader, writer)
        except ProgramStoppedError as stop:
            if not stop.drops:
                await until_client_leaves(reader)

    return one_client_endpoint(device, protocol, attend, cell)


async def _serve(
    cell: Cell, program: MappdkProgram, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    """Answer until the client says that it goes, or is gone."""
    lines = RequestReader()
    while data := await reader.read(_CHUNK_BYTES):
        lines.receive_data(data)
        while (line := lines.next_message()) is not None:
            answer = partial(program.answer, line)
            await say_to_client(cell, writer, await program.answer_meanwhile_heard(answer, reader))
            if line == Command.EXIT:
                await until_client_leaves(reader)
                return
