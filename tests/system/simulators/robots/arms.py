"""Simulated controllers with their drivers, served in memory, with the arm moving in its own time."""

import asyncio
import contextlib
from dataclasses import replace
from typing import Any

import numpy as np

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from truepose_drivers.abb_rws import protocol as rws
from truepose_drivers.abb_rws.driver import RwsRobot
from truepose_drivers.abb_rws.motion import Patience
from truepose_drivers.api import MotionLimits
from truepose_drivers.fanuc_rmi.driver import RmiRobot
from truepose_drivers.fanuc_rmi.protocol import CONNECT_PORT
from truepose_drivers.kuka_variable_proxy.driver import KukaRobot
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.universal_robots.driver import Ports, UniversalRobot
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, OurProgram
from truepose_simulators.instruments.robot.abb_rws.server import web_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller as FanucController
from truepose_simulators.instruments.robot.fanuc_rmi.endpoints import connect_endpoint, session_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.program import RmiMove
from truepose_simulators.instruments.robot.kuka import Variables, proxy_endpoint
from truepose_simulators.instruments.robot.universal_robots import Controller, Programs
from truepose_simulators.instruments.robot.universal_robots_ports import (
    dashboard_endpoint,
    rtde_endpoint,
    script_endpoint,
)
from truepose_simulators.scenarios.file import load_scenario

LIMITS = MotionLimits(tool_speed_mm_s=1e5)  # 20 deg/s


def radians(*angles_deg: float) -> tuple[float, ...]:
    return tuple(np.radians(angles_deg).tolist())


class Bench:
    """An arm in a cell, and links to its controller; whoever holds `ends` can hang up."""

    scenario: str
    home = (0.0,) * 6
    target = radians(30.0, 20.0, -50.0, 10.0, 20.0, 30.0)
    reads_to_rad = 1e-5  # of what the controller tells
    arrives_to_rad = 1e-7
    stops_between_deg = (5.0, 50.0)  # joint 1, of whoever is stopped a second or two after it set off

    def __init__(self, **arm: Any) -> None:
        clock = CellClock(1, wall_s=asyncio.get_running_loop().time)
        scenario = load_scenario(self.scenario)
        scenario = replace(scenario, noise=False, arm=replace(scenario.arm, **arm))
        self.cell = Cell(scenario, 1, clock)
        self.ends: list = []

    @property
    def away(self) -> tuple[float, ...]:
        """Joint 1 elsewhere: three seconds or more."""
        return (np.radians(60.0), *self.home[1:])

    def driver(self):
        raise NotImplementedError

    def link(self, endpoint, chunk_bytes=11) -> MemoryLink:
        return MemoryLink(in_memory(endpoint, self.ends), chunk_bytes=chunk_bytes)

    async def connected(self, **options: Any):
        robot = self.driver(**options)
        await robot.connect()
        await robot.set_limits(LIMITS)
        return robot

    def hang_up(self) -> None:
        for end in self.ends:
            end.close()

    def gave_up(self) -> bool:
        """Whether the program says that it does not go on."""
        return not self.cell.robot_moves

    def shown_deg(self) -> float:
        return float(np.degrees(self.cell.joints_rad[0]))

    @contextlib.asynccontextmanager
    async def moving(self, robot):
        """Have the arm a second under way; yields the motion, which is ended with the context."""
        motion = asyncio.create_task(robot.move_joints(self.away))
        while not self.cell.robot_moves:
            await asyncio.sleep(0.01)
        await asyncio.sleep(1.0)
        assert self.cell.robot_moves
        try:
            yield motion
        finally:
            motion.cancel()
            await asyncio.wait({motion})
            await robot.close()

    async def rests_within(self, limit_s: float) -> bool:
        """Whether the arm stands after so long, on its way, and goes on standing."""
        await asyncio.sleep(limit_s)
        stands_deg, (least_deg, most_deg) = self.shown_deg(), self.stops_between_deg
        await asyncio.sleep(5.0)
        return self.shown_deg() == stands_deg and least_deg < stands_deg < most_deg


class FanucBench(Bench):
    """An LR Mate with the Remote Motion Interface."""

    scenario = "lrmate-rmi"
    stops_between_deg = (10.0, 50.0)

    def __init__(self, **changes: Any) -> None:
        super().__init__()
        self.controller = FanucController(self.cell, **changes)
        self.session = session_endpoint(self.controller, RmiMove(self.controller))
        self.first = connect_endpoint(self.session)

    def to_port(self, port: int) -> MemoryLink:
        return self.link(self.first if port == CONNECT_PORT else self.session)

    def driver(self) -> RmiRobot:
        return RmiRobot(self.to_port, MonotonicClock())

    def gave_up(self) -> bool:
        return not self.controller.status.running


class KukaBench(Bench):
    """A KR 6 behind a variable proxy."""

    scenario = "kr6-clean"
    home = radians(0.0, -90.0, 90.0, 0.0, 0.0, 0.0)
    target = radians(30.0, -70.0, 40.0, 10.0, 20.0, 30.0)
    reads_to_rad = 1e-6
    arrives_to_rad = 1e-6
    stops_between_deg = (5.0, 40.0)

    def __init__(self) -> None:
        super().__init__()
        self.variables = Variables(self.cell)
        self.endpoint = proxy_endpoint(self.cell, self.variables)

    def driver(self) -> KukaRobot:
        return KukaRobot(self.link(self.endpoint), MonotonicClock())

    def gave_up(self) -> bool:
        return self.variables.program.state.given_up == 1


class UniversalBench(Bench):
    """A UR10 with its three ports."""

    scenario = "ur10-clean"
    home = radians(0.0, -90.0, -90.0, -90.0, 90.0, 0.0)
    target = radians(30.0, -70.0, -80.0, -90.0, 70.0, 30.0)
    reads_to_rad = 1e-9

    def __init__(self) -> None:
        super().__init__()
        self.controller = Controller(self.cell)
        self.programs = Programs(self.controller)

    def driver(self) -> UniversalRobot:
        endpoints = (
            rtde_endpoint(self.controller),
            script_endpoint(self.programs),
            dashboard_endpoint(self.controller, self.programs),
        )
        return UniversalRobot(Ports(*map(self.link, endpoints)), MonotonicClock())


class WebBench(Bench):
    """An IRB 120 with Robot Web Services."""

    scenario = "irb120-clean"
    target = radians(10.12345, -20.5, 15.0, 30.0, 40.0, -50.98765)
    reads_to_rad = 1e-4 * np.pi / 180.0

    def __init__(self, task=OurProgram) -> None:
        super().__init__()
        self.controller = AbbController(self.cell)
        self.controller.task = task(self.controller)
        self.endpoint = web_endpoint(self.cell, self.controller)

    def driver(self, login=None, *, chunk_bytes=97) -> RwsRobot:
        link = self.link(self.endpoint, chunk_bytes)
        return RwsRobot(link, MonotonicClock(), login, patience=Patience(stands_s=3.0))

    def reported(self) -> rws.Progress:
        return rws.decode_report(self.controller.task.variables[rws.REPORT]).progress

    def gave_up(self) -> bool:
        return self.reported() is rws.Progress.GIVEN_UP
