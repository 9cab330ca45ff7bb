"""Afternoon: everything that was measured is computed anew on Dask."""

import asyncio
import hashlib
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from tests.helpers.ports import free_port
from tests.studies.managers_day.day import Day
from tests.studies.managers_day.programs import Running, answered, until


async def compute_anew(day: Day) -> None:
    """Compute the archive of a cell by processes and by Dask's workers, one of which is killed."""
    cell = day.cells[0]
    with day.diary.step(f"The archive of {cell.name} is computed anew: by two processes, then on Dask"):
        copy = day.out / "archive.sqlite3"
        await answered("backup", str(copy), "--database", cell.url_of_database, "--replace")
        alone = await answered("reanalyse", str(copy), "--out", str(day.out / "alone"), "--workers", "2")
        async with dask_workers(day.out) as (address, workers):
            anew = day.out / "on-dask"
            computing = asyncio.create_task(
                answered("reanalyse", str(copy), "--out", str(anew), "--workers", f"dask://{address}")
            )

            async def first_result() -> bool | None:
                return computing.done() or any(anew.glob("results/*")) or None

            await until(first_result, "a first result of Dask")
            assert not computing.done()
            await workers[0].kill()
            found = await computing
        assert not alone["failed"] and not found["failed"], (alone, found)
        assert bits(day.out / "alone" / "results") == bits(anew / "results")
        day.diary.saw(
            f"{found['computed']} campaigns, one of two workers killed on the way: all there, with the same "
            f"bits; {len(found['differing'])} differ from what the cell has on record"
        )


@asynccontextmanager
async def dask_workers(folder: Path) -> AsyncIterator[tuple[str, list[Running]]]:
    """Start a scheduler and two workers with Dask's own commands."""
    address, log = f"127.0.0.1:{free_port()}", folder / "dask.log"
    dask = f"{Path(sys.executable).parent}/dask"
    host, port = address.split(":")
    begin = ("--host", host, "--port", port, "--no-dashboard")
    started = [await Running.begin((dask, "scheduler", *begin), log, folder)]
    try:
        worker = (dask, "worker", f"tcp://{address}", "--nthreads", "1", "--host", host, "--no-dashboard")
        started += [await Running.begin(worker, log, folder) for _ in range(2)]
        yield address, started[1:]
    finally:
        for program in reversed(started):
            await program.kill()


def bits(results: Path) -> dict[str, str]:
    """Return the hash of each result by its name."""
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in results.iterdir()}
