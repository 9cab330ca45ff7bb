"""A service that is killed while the arm moves: where a simulated arm comes to rest, and when.

The cell is a process of its own in real time, as a real one would be; the speed is that of an arm in setup.
"""

import asyncio
import contextlib
import json
import sys

import httpx
import numpy as np

from tests.studies.interruptions.killed_service import KilledService
from truepose.demo.simulated_operator import SimulatedOperator
from truepose.demo.truth import cell_endpoint
from truepose_drivers.abb_open_abb.protocol import LogReader

DRIVERS = {"robot": "abb_open_abb", "ballbar": "heidenhain_nd", "hands": "cell_hands", "clock": "cell_clock"}
LIMITS = "[limits]\ntool_speed_mm_s = 20.0\norientation_speed_deg_s = 3.0\n"
FIRST_MOTION = "placement-1/cup-1/move"
TARGET_DEG = [40.0, 20.0, 10.0, 0.0, 30.0, 0.0]  # 40 deg at 3 deg/s: a quarter of a minute
PLACEMENT = {
    "x_mm": 350.0,
    "y_mm": 0.0,
    "z_mm": 50.0,
    "cups_mm": [[350.0, 0.0, 50.0], [650.0, 0.0, 50.0], [500.0, 260.0, 50.0]],
    "setups": [{"base_point": k, "joints_deg": TARGET_DEG} for k in (1, 2, 3)],
    "poses": [
        {
            "config": 1,
            "joints_deg": TARGET_DEG,
            "legs": [[1, 1], [1, 2], [2, 2], [2, 3], [3, 3], [3, 1]],
        }
    ],
}
BETWEEN_LINES_S = 0.25  # of joints in the logger's stream, rounded up


@contextlib.asynccontextmanager
async def standing_cell(folder, server):
    """Start a cell with a controller program; yields its endpoints by device."""
    scenario = folder / "irb120-watched.toml"
    scenario.write_text(f'extends = "irb120-clean"\n[arm]\nserver = "{server}"\n')
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "truepose_simulators", str(scenario), "--pace", "1"),
        stdout=asyncio.subprocess.PIPE,
    )
    try:
        endpoints = {}
        while "hands" not in endpoints:
            told = json.loads(await process.stdout.readline())
            endpoints.setdefault(told["device"], told)
        yield endpoints
    finally:
        process.kill()
        await process.wait()


def cell_file(endpoints):
    lines = ['robot = "abb-irb-120"', LIMITS, "[ballbar]", "base_points = 3"]
    for name, driver in DRIVERS.items():
        at = endpoints[name]
        lines += ["[[device]]", f'name = "{name}"', f'driver = "{driver}"']
        lines += [f'host = "{at["host"]}"', f"port = {at['port']}"]
    return "\n".join(lines) + "\n"


class Log:
    """Where the arm is, as the controller's own logger says it."""

    def __init__(self, reader):
        self._reader = reader
        self._lines = LogReader()

    async def next(self):
        while True:
            line = self._lines.next_line()
            if line is not None and line.kind == 1:
                return line.elapsed_s, np.array(line.values)
            if line is None:
                self._lines.receive_data(await self._reader.read(4096))

    async def until_moved(self, degrees):
        """Return once the arm has gone so far."""
        _, start = await self.next()
        while np.max(np.abs((await self.next())[1] - start)) <= degrees:
            pass

    async def until_rest(self):
        """Return when and where the arm was first seen where it still is a second later."""
        since_s, place = await self.next()
        while True:
            time_s, here = await self.next()
            if not np.array_equal(here, place):
                since_s, place = time_s, here
            if time_s - since_s > 1.0:
                return since_s, place


async def cell_time_s(endpoint):
    async with cell_endpoint(endpoint["host"], endpoint["port"]) as clock:
        return (await clock.ask("now"))["now_s"]


async def killed_in_motion(folder, server):
    """Kill the service while the arm moves; returns seconds until it rests, its place, what was said."""
    async with standing_cell(folder, server) as endpoints:
        (folder / "cell.toml").write_text(cell_file(endpoints))
        at = endpoints["robot-log"]
        reader, writer = await asyncio.open_connection(at["host"], at["port"])
        log = Log(reader)
        service = KilledService(folder / "cell.toml", folder / "sessions.sqlite3", folder / "service.log")
        await service.start()
        try:
            async with httpx.AsyncClient(base_url=service.url, timeout=30, trust_env=False) as http:
                wanted = {"name": "killed", "placements": [PLACEMENT]}
                created = await http.post("/api/v1/sessions", json={"kind": "ballbar", **wanted})
                person = SimulatedOperator(http, created.json()["id"], "tablet-1")
                session = await person.walk(until=FIRST_MOTION)
                await person.act("confirm", FIRST_MOTION)
                await log.until_moved(2.0)
                await service.kill()
                killed_s = await cell_time_s(endpoints["clock"])
        finally:
            await service.kill()
        rest_s, place = await log.until_rest()
        writer.close()
    return rest_s - killed_s, place, session["motion_notice"]


async def test_a_killed_service_leaves_an_arm_that_nobody_watches_to_its_piece_of_a_second(tmp_path):
    after_s, place, said = await killed_in_motion(tmp_path, "stock")

    assert after_s <= 1.0 + BETWEEN_LINES_S
    assert np.max(np.abs(place - TARGET_DEG)) > 10.0  # the whole motion takes a quarter of a minute
    assert "the arm keeps moving for up to 1 s" in said
