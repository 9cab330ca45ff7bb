"""TRUEPOSE, our program on the controller; there is no interpreter: what it does is written here again."""

import asyncio
from dataclasses import replace

import numpy as np

from truepose_drivers.kuka_variable_proxy.protocol.variables import SILENCE_S, ProgramState
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError, check_range
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.physics.rigid import FloatArray

_LOOK_S = 0.05  # between two looks at the beat; the real program is told by an interrupt
_PERCENT = 100.0
_NO_LIMIT = 1e12  # of a speed, in any unit
_ORIGIN = np.zeros(3)


class TruePose:
    """The program and its variables."""

    def __init__(self, cell: Cell) -> None:
        self.state = ProgramState(0, 0, 0, 0)
        self.target_deg: tuple[float, ...] = (0.0,) * 12
        self.percent = 1
        self.most_override = 1
        self.beat = 0
        self.override = 100  # of the controller, as set on its pendant
        self.stopped = False  # by a stop of the arm, before somebody starts it again
        self._cell = cell
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
            if await self._heard_first():
                await self._move(number)
            else:
                self.state = replace(self.state, given_up=number)
        except TargetOutOfRangeError:
            self.state = replace(self.state, refused=number)
        except ArmStoppedError:
            self.stopped = True

    async def _heard_first(self) -> bool:
        """Whether somebody gives a beat; where time costs nothing nobody is late."""
        beat, unheard_s = self.beat, 0.0
        while self._cell.clock.waits and self.beat == beat and unheard_s < SILENCE_S:
            await self._cell.clock.sleep(_LOOK_S)
            unheard_s += _LOOK_S
        return unheard_s < SILENCE_S

    async def _move(self, number: int) -> None:
        fault = self._cell.faults.next_move()
        if isinstance(fault, RobotRefuses):
            raise TargetOutOfRangeError("the target was refused")
        share = self.percent / _PERCENT * min(self.override, self.most_override) / _PERCENT
        limits = SpeedLimits(_NO_LIMIT, _NO_LIMIT, joint_share=share)
        motion = self._cell.set_off([self._target_rad()], limits, _ORIGIN)
        if not await self._heard_for(motion.duration_s):
            self._cell.halt_robot()
            self.state = replace(self.state, given_up=number)
        elif not isinstance(fault, RobotHangs):
            self.state = replace(self.state, arrived=number)

    async def _heard_for(self, duration_s: float) -> bool:
        """Whether the beat goes on for so long; raises ArmStoppedError."""
        beat, unheard_s = self.beat, 0.0
        while self._cell.clock.waits and duration_s > _LOOK_S:
            await self._cell.glide(_LOOK_S)
            duration_s -= _LOOK_S
            before, beat = beat, self.beat
            unheard_s = unheard_s + _LOOK_S if beat == before else 0.0
            if unheard_s >= SILENCE_S:
                return False
        await self._cell.glide(duration_s)
        return True

    def _target_rad(self) -> FloatArray:
        target: FloatArray = np.radians(self.target_deg[: self._cell.plant.arm.n_joints])
        return target
