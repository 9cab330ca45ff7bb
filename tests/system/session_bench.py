"""A simulated cell as processes know it: its servers on loopback, real drivers, a journal in memory."""

import asyncio
import json
import math
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.tracker.fakes import ListLedger
from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.workspace.bodies import bodies_of
from truepose.planning.workspace.space import WorkSpace
from truepose.sessions.engine.ways import look_in
from truepose.sessions.tracker.cell import SessionCell
from truepose_drivers.abb_open_abb.driver import PLUGIN as OPEN_ABB
from truepose_drivers.abb_rws.driver import PLUGIN as RWS
from truepose_drivers.cell_clock.driver import PLUGIN as CLOCK
from truepose_drivers.fanuc_mappdk.driver import PLUGIN as MAPPDK
from truepose_drivers.fanuc_rmi.driver import PLUGIN as RMI
from truepose_drivers.kuka_variable_proxy.driver import PLUGIN as KUKA
from truepose_drivers.leica_emscon.driver import PLUGIN as TRACKER
from truepose_drivers.universal_robots.driver import PLUGIN as UNIVERSAL

_ROBOTS = {plugin.protocol: plugin for plugin in (OPEN_ABB, RWS, MAPPDK, RMI, UNIVERSAL, KUKA)}
# Of a UR10, whose maker states full turns only: elbow above the table, tool in front.
_ELBOW_UP = tuple(
    JointRange(math.radians(lower), math.radians(upper))
    for lower, upper in ((-90, 90), (-120, -60), (-120, -20), (-180, 0), (-120, 120), (-180, 180))
)
LOOK_S = 0.01  # between looks of an operator: one who looks all the time takes the cell its processor
_LIMIT = 1 << 24  # bytes of one answer of the truth endpoint


class Bench:
    """Devices opened by their plugins, and the simulator's own knowledge."""

    def __init__(self, endpoints: dict[str, dict[str, Any]], scenario: str, seed: int) -> None:
        address = {name: {"host": found["host"], "port": found["port"]} for name, found in endpoints.items()}
        self._truth = address["truth"]
        self.robot_address = address["robot"]
        self.clock = CLOCK.open(address["clock"], None)
        self.tracker_address = address["tracker"]
        self.tracker = TRACKER.open(self.tracker_address, self.clock)
        robot = {**address["robot"]}
        if endpoints["robot"]["protocol"] == MAPPDK.protocol:
            robot["logger_port"] = address["robot-logger"]["port"]
        elif "robot-log" in endpoints and endpoints["robot"]["protocol"] == OPEN_ABB.protocol:
            robot["log_port"] = address["robot-log"]["port"]
        elif endpoints["robot"]["protocol"] == UNIVERSAL.protocol:
            robot["script_port"] = address["robot-script"]["port"]
            robot["dashboard_port"] = address["robot-dashboard"]["port"]
        self.robot = _ROBOTS[endpoints["robot"]["protocol"]].open(robot, self.clock)
        self.journal = ListLedger()
        described = simulated_cell(scenario, seed)
        self.described = described
        self.cell = SessionCell(
            tracker=self.tracker,
            robot_controller=self.robot,
            clock=self.clock,
            robot=described.robot,
            base=described.base_nominal,
            nests=described.nests,
            fixed_nests=described.fixed_nests,
            look_at_ways=look_in(bodies_of(described)),
            tracker_position_mm=described.tracker_position_mm,
            joint_limits=described.robot.joint_limits,
        )
        self.space = WorkSpace(
            robot=described.robot,
            base=described.base_nominal,
            nests=described.nests,
            ranges=described.robot.calibration_ranges or _ELBOW_UP,
            tracker_position_mm=described.tracker_position_mm,
            joint_limits=described.robot.joint_limits,
            approach_offset_rad=-0.0872664626,
        )

    async def ask(self, **request: Any) -> dict[str, Any]:
        """Put a question to the truth endpoint."""
        reader, writer = await asyncio.open_connection(**self._truth, limit=_LIMIT)
        writer.write(json.dumps(request).encode() + b"\n")
        answer = json.loads(await reader.readline())
        writer.close()
        await writer.wait_closed()
        assert "error" not in answer, answer
        return answer

    async def true_errors_mm(self) -> FloatArray:
        """Return how far each reading is from what is true in the cell now, shape (n,)."""
        points = self.journal.points
        joints, nests = [point.commanded_rad for point in points], [point.nest for point in points]
        true = await self.ask(op="positions", joints_rad=joints, nests=nests)
        read = np.array([point.position_world_mm for point in points])
        off: FloatArray = np.linalg.norm(read - np.array(true["positions_mm"]), axis=1)
        return off

    async def close(self) -> None:
        await self.tracker.close()
        await self.robot.close()
        await self.clock.close()


@asynccontextmanager
async def bench(
    scenario: str, seed: int, *arguments: str, scenario_file: Path | None = None
) -> AsyncIterator[Bench]:
    """Start the simulators at pace 0, with further arguments, and end them again.

    `scenario_file` is the cell where it differs from the shipped one in what the service does not know.
    """
    process = await asyncio.create_subprocess_exec(
        *(
            sys.executable,
            "-m",
            "truepose_simulators",
            str(scenario_file or scenario),
            "--seed",
            str(seed),
            "--pace",
            "0",
            *arguments,
        ),
        stdout=asyncio.subprocess.PIPE,
    )
    assert process.stdout is not None
    endpoints: dict[str, dict[str, Any]] = {}
    async with asyncio.timeout(HANGS_S):
        while "truth" not in endpoints:
            endpoint = json.loads(await process.stdout.readline())
            endpoints[endpoint["device"]] = endpoint
    opened = Bench(endpoints, scenario, seed)
    try:
        yield opened
    finally:
        await opened.close()
        process.terminate()
        await process.wait()
