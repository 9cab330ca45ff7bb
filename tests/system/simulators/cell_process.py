"""Simulated cells as processes of their own, and drivers for what they announce."""

import asyncio
import contextlib
import json
import sys

from tests.integration.drivers_of_checkout import drivers_of_checkout


@contextlib.asynccontextmanager
async def python(*arguments):
    """Run a module or script; it is killed with the context, also where it was stopped."""
    process = await asyncio.create_subprocess_exec(sys.executable, *arguments, stdout=asyncio.subprocess.PIPE)
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


class StartedCell:
    """What a cell announced up to the endpoint of its faults, and drivers for it."""

    def __init__(self, announced) -> None:
        self.announced = announced
        self._drivers = drivers_of_checkout()
        self._opened: list = []

    def address(self, name) -> dict:
        """Where the device or the protocol of this name is found."""
        entry = next(entry for entry in self.announced if name in {entry["device"], entry["protocol"]})
        return {key: entry[key] for key in ("host", "port")}

    async def connected(self, driver, name, clock=None, **options):
        opened = self._drivers.open(driver, {**self.address(name), **options}, clock)
        self._opened.append(opened)
        if driver != "cell_clock":
            await opened.connect()
        return opened

    async def close(self) -> None:
        for driver in self._opened:
            await driver.close()


@contextlib.asynccontextmanager
async def started_cell(*arguments):
    async with python("-m", "truepose_simulators", *arguments) as process:
        announced = []
        while not announced or announced[-1]["device"] != "faults":
            announced.append(json.loads(await process.stdout.readline()))
        cell = StartedCell(announced)
        try:
            yield cell
        finally:
            await cell.close()
