"""RMI_MOVE, the controller's own program: instructions one after the other, each reported at its end.

Nobody has to be there for it: what was sent is carried out. An instruction that fails has all others held
until the program is begun anew, or the fault reset and the program continued.
"""

import asyncio
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import Packet, Session, reply, session
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, check_range, nominal_flange
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller
from truepose_simulators.instruments.robot.fanuc_rmi.registers import RefusedError, six_in
from truepose_simulators.instruments.robot.kinematics import (
    UnreachableError,
    displayed_deg,
    joints_rad,
    reach,
    straight_line,
)
from truepose_simulators.physics.rigid import FloatArray

_NO_LIMIT = 1e12  # of a speed, in any unit
_NO_TIME_S = 1e-9  # of a motion to where the arm stands already
_PERCENT = 100.0
_OUT_OF_REACH = "MOTN-017 Limit error"
_STOPPED = "SRVO-001 Operator panel E-stop"
_JOINTS = tuple(f"J{number}" for number in range(1, 7))
_ORIGIN = np.zeros(3)
_TERM_TYPES = ("FINE", "CNT", "CR")


class RmiMove:
    """The program; it tells whoever is connected of its instructions' ends."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._cell = controller.cell
        self._waiting: asyncio.Queue[Packet] = asyncio.Queue()
        self._running: asyncio.Task[None] | None = None
        self._held = False
        self._gliding: asyncio.Future[None] | None = None
        self._resumed = asyncio.Event()
        self._resumed.set()
        self.tell: Callable[[Packet], None] = lambda _: None  # to the client, if there is one
        controller.on_abort = self._abort
        controller.on_pause = self._pause
        controller.on_continue = self._continue

    def take(self, instruction: Packet) -> None:
        """Queue an instruction, or refuse it at once."""
        error = self._why_not_taken(instruction)
        if error != 0:
            self.tell(reply(instruction, error))
            return
        status = self._controller.status
        self._controller.status = replace(status, next_sequence=status.next_sequence + 1)
        self._waiting.put_nowait(instruction)
        if self._running is None or self._running.done():
            self._running = asyncio.create_task(self._run())

    def _why_not_taken(self, instruction: Packet) -> int:
        if not self._controller.status.running:
            return protocol.NOT_RUNNING
        if self._held:
            return protocol.IN_HOLD
        if instruction.fields.get("SequenceID") != self._controller.status.next_sequence:
            return protocol.WRONG_SEQUENCE
        return 0

    async def _run(self) -> None:
        while not self._waiting.empty():
            instruction = self._waiting.get_nowait()
            self.tell(await self._carried_out(instruction))

    async def _carried_out(self, instruction: Packet) -> Packet:
        try:
            await self._carry_out(instruction)
        except RefusedError as refusal:
            self._hold(refusal.shown)
            return reply(instruction, refusal.error)
        except (TargetOutOfRangeError, UnreachableError):
            self._hold(_OUT_OF_REACH)
            return reply(instruction, protocol.BAD_DESTINATION)
        except ArmStoppedError:
            self._hold(_STOPPED)
            return session(Session.SYSTEM_FAULT, SequenceID=instruction.fields["SequenceID"])
        except RemoteProtocolError:
            return reply(instruction, protocol.BAD_POSITION_DATA)
        return reply(instruction)

    def _hold(self, shown: str) -> None:
        self._held = True
        if shown:
            self._controller.shown_errors.append(shown)

    def _stop(self) -> None:
        if self._running is not None:
            self._running.cancel()
            self._running = None  # what is queued next does not wait until that one is gone
        self._waiting = asyncio.Queue()
        self._cell.halt_robot()

    def _abort(self) -> None:
        self._stop()
        self._held = False
        self._resume()

    def _pause(self) -> None:
        self._controller.paused = True
        self._resumed.clear()
        if self._gliding is not None:
            self._gliding.cancel()

    def _continue(self) -> None:
        self._held = bool(self._controller.shown_errors)
        if not self._held:
            self._resume()

    def _resume(self) -> None:
        self._controller.paused = False
        self._resumed.set()

    async def _carry_out(self, instruction: Packet) -> None:
        match instruction.name:
            case "FRC_JointMotionJRep" | "FRC_JointRelativeJRep":
                await self._turn_joints([self._joints_target(instruction)], instruction)
            case "FRC_JointMotion" | "FRC_JointRelative":
                await self._turn_joints([self._reached(self._flange_target(instruction))], instruction)
            case "FRC_LinearMotion" | "FRC_LinearRelative":
                await self._go_straight([self._flange_target(instruction)], instruction)
            case "FRC_CircularMotion" | "FRC_CircularRelative":
                # The measured stops are what counts: the arc is replaced by its two chords.
                via = self._flange_target(instruction, "Via")
                await self._go_straight([via, self._flange_target(instruction)], instruction)
            case "FRC_LinearMotionJRep" | "FRC_LinearRelativeJRep":
                target = self._joints_target(instruction)
                await self._go_straight([*nominal_flange(self._cell.plant.arm, target[None])], instruction)
            case "FRC_WaitTime":
                await self._wait(instruction.number("Time"))
            case "FRC_SetUFrame":
                self._controller.select(
                    replace(instruction, fields={"UFrameNumber": instruction.whole("FrameNumber")})
                )
            case "FRC_SetUTool":
                self._controller.select(
                    replace(instruction, fields={"UToolNumber": instruction.whole("ToolNumber")})
                )
            case "FRC_Call" | "FRC_WaitDIN":
                pass
            case _:
                raise RefusedError(protocol.UNKNOWN_INSTRUCTION)

    async def _wait(self, duration_s: float) -> None:
        if duration_s < 0.0:
            raise RefusedError(protocol.BAD_VALUE)
        await self._cell.clock.sleep(duration_s)

    def _joints_target(self, instruction: Packet) -> FloatArray:
        stated = instruction.part("JointAngle")
        shown = np.array([stated.number(joint) for joint in _JOINTS])
        if "Relative" in instruction.name:
            shown += displayed_deg(self._cell.joints_rad)
        return joints_rad(shown)

    def _flange_target(self, instruction: Packet, which: str = "") -> FloatArray:
        self._controller.select(instruction.part(f"{which}Configuration"))
        frames, position = self._controller.frames, six_in(instruction.part(f"{which}Position"))
        if "Relative" in instruction.name:
            here = frames.position(self._cell.joints_rad)
            position = tuple(a + b for a, b in zip(here, position, strict=True))
        return frames.flange(position)

    def _reached(self, flange: FloatArray) -> FloatArray:
        return reach(self._cell.plant.arm, flange, self._cell.joints_rad)

    async def _go_straight(self, flanges: Sequence[FloatArray], instruction: Packet) -> None:
        speed_mm_s = _speed(instruction, "mmSec", 1e5) * self._override()
        await self._move(list(self._lines(flanges)), SpeedLimits(speed_mm_s, _NO_LIMIT))

    def _lines(self, flanges: Sequence[FloatArray]) -> Iterator[FloatArray]:
        arm, joints = self._cell.plant.arm, self._cell.joints_rad
        start = nominal_flange(arm, joints[None])[0]
        for begun, ended in pairwise([start, *flanges]):
            for frame in straight_line(begun, ended):
                joints = reach(arm, frame, joints)
                yield joints

    async def _turn_joints(self, waypoints: list[FloatArray], instruction: Packet) -> None:
        share = _speed(instruction, "Percent", _PERCENT) / _PERCENT * self._override()
        await self._move(waypoints, SpeedLimits(_NO_LIMIT, _NO_LIMIT, joint_share=share))

    async def _move(self, waypoints: list[FloatArray], limits: SpeedLimits) -> None:
        check_range(self._cell.plant.arm, waypoints[-1])
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise RefusedError(protocol.BAD_DESTINATION, "MOTN-023 In singularity")
        await self._travel(waypoints, limits)
        if isinstance(fault, RobotHangs):
            await asyncio.Event().wait()

    async def _travel(self, waypoints: list[FloatArray], limits: SpeedLimits) -> None:
        """Move until at rest at the last waypoint, however often the program is paused meanwhile."""
        while waypoints:
            await self._resumed.wait()
            under_way = self._cell.set_off(waypoints, limits, _ORIGIN)
            share = await self._share_of_way(under_way.duration_s)
            waypoints = waypoints[int(share * len(waypoints)) :]

    async def _share_of_way(self, duration_s: float) -> float:
        """Let a motion go by, and return how much of it was done when it ended or was paused."""
        begun_s = self._cell.clock.now_s
        self._gliding = asyncio.ensure_future(self._cell.glide(duration_s))
        try:
            await self._gliding
        except asyncio.CancelledError:
            # Cancelled by an abort, and not by a pause, which alone lets the rest of the motion follow.
            if self._resumed.is_set():
                raise
            self._cell.halt_robot()
            return min(1.0, (self._cell.clock.now_s - begun_s) / max(duration_s, _NO_TIME_S))
        return 1.0

    def _override(self) -> float:
        return self._controller.status.override_percent / _PERCENT


def _speed(instruction: Packet, unit: str, fastest: float) -> float:
    """Return the speed of a motion; raises RefusedError."""
    if instruction.fields.get("SpeedType") != unit:
        raise RefusedError(protocol.BAD_SPEED_TYPE)
    if instruction.fields.get("TermType") not in _TERM_TYPES:
        raise RefusedError(protocol.BAD_TERM_TYPE)
    if "TermValue" in instruction.fields and not 0.0 <= instruction.number("TermValue") <= _PERCENT:
        raise RefusedError(protocol.BAD_TERM_VALUE)
    speed = instruction.number("Speed")
    if not 0.0 < speed <= fastest:
        raise RefusedError(protocol.BAD_SPEED)
    return speed
