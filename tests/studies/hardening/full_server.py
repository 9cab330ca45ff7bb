"""The disk of a database server fills up while programs deliver readings: what is kept, how soon it goes on.

`python -m tests.studies.hardening.full_server --out DIR [--runs N]` fills the file system of DIR, so that has
to be a small one (`mount -t tmpfs -o size=160m tmpfs DIR`); the server's data and log lie there, with
`--only-log` its log alone, and nothing else does. Each run fills it to within a few blocks, waits until
deliveries are refused, and makes room. A server that ends, as it does where its log finds no room, is started
again, as a service manager would.
"""

import asyncio
import contextlib
import os
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import httpx
import numpy as np

from tests.helpers.postgresql.bare import BareServer
from tests.studies.plant_kills.__main__ import WITHOUT_INSTRUMENTS
from tests.studies.plant_kills.compared import kept_readings, read_acknowledged
from tests.studies.plant_kills.delivering import Acknowledged, Sender, deliver
from tests.studies.plant_kills.services import KilledService, ServedCell
from tests.studies.running import leave, study_options
from truepose.storage.integrity.verification import verify_left_at

_LARGEST = 256 * 2**20  # of a file system that is filled
_BLOCK = 64 * 1024
_LEFT_OPEN = 512 * 1024  # at most, of the disk
_PROGRAMS = 2
_TOGETHER = 300  # readings of a delivery: several pages of the server's
_BEFORE = 20  # deliveries between two disks
_FULL_S = 3.0
_PATIENCE_S = 300.0


@dataclass
class Filled:
    """What came of all runs."""

    runs: int = 0
    acknowledged: int = 0  # deliveries
    readings: int = 0
    refused: int = 0
    servers_ended: int = 0  # for want of room for their log
    unsaid: int = 0  # runs in which /health said nothing
    lost: int = 0  # acknowledged, and not there at the end as they were sent
    findings: int = 0
    again_s: list[float] = field(default_factory=list)  # from room until a delivery was acknowledged
    said: list[str] = field(default_factory=list)  # by /health
    load: list[float] = field(default_factory=list)


async def full_server(disk: Path, folder: Path, runs: int, seed: int, *, only_log: bool) -> Filled:
    """Fill the disk so often."""
    server = BareServer(folder / "server", (folder if only_log else disk) / "data")
    server.make("cell", log=disk / "log")
    (folder / "cell.toml").write_text(WITHOUT_INSTRUMENTS)
    served = ServedCell(folder / "cell.toml", server.url("cell"), folder / "cell.log")
    service, found, rng = (
        KilledService("cell", served, folder / "said"),
        Filled(),
        np.random.default_rng(seed),
    )
    acknowledged, ended = Acknowledged(folder / "acknowledged.jsonl"), asyncio.Event()
    await server.start()
    watching = asyncio.create_task(_watch(server, found))
    sender = Sender(service.url)
    try:
        await service.up()
        async with asyncio.TaskGroup() as together:
            for own in rng.spawn(_PROGRAMS):
                together.create_task(deliver("cell", sender, acknowledged, own, ended, _TOGETHER))
            for _ in range(runs):
                await _fill_once(disk / "ballast", service, sender, acknowledged, found, rng)
            ended.set()
        watching.cancel()
        found.findings = len(verify_left_at(server.url("cell")).findings)
        told = read_acknowledged(folder / "acknowledged.jsonl")
        kept = kept_readings(server.url("cell"), told)
        found.lost = kept.unseen + kept.other_values + kept.doubled + kept.reordered
        found.acknowledged, found.readings = len(told), sum(one["count"] for one in told)
    finally:
        watching.cancel()
        await service.kill()
        await server.stop_at_once()
    return found


async def _watch(server: BareServer, found: Filled) -> None:
    """Start the server again where it has ended."""
    while True:
        if server.ended:
            found.servers_ended += 1
            with contextlib.suppress(TimeoutError):
                await server.start()
        await asyncio.sleep(0.2)


async def _fill_once(
    ballast: Path,
    service: KilledService,
    sender: Sender,
    acknowledged: Acknowledged,
    found: Filled,
    rng: np.random.Generator,
) -> None:
    await _until(acknowledged, acknowledged.count + _BEFORE)
    before = sender.refused
    await asyncio.to_thread(_fill, ballast, int(rng.integers(_LEFT_OPEN)))
    async with asyncio.timeout(_PATIENCE_S):
        while sender.refused == before:
            await asyncio.sleep(0.02)
    said = await _fault(service)
    found.unsaid += said is None
    found.said.append(said or "")
    await asyncio.sleep(float(rng.uniform(0.0, _FULL_S)))
    ballast.unlink()
    begun_s = time.monotonic()
    await _until(acknowledged, acknowledged.count + 1)
    found.again_s.append(time.monotonic() - begun_s)
    found.refused += sender.refused - before
    found.load.append(os.getloadavg()[0])
    found.runs += 1


async def _fault(service: KilledService) -> str | None:
    """Return what /health says is amiss, looked at for a second: it may say so a moment later."""
    async with httpx.AsyncClient(base_url=service.url, trust_env=False, timeout=60) as http:
        for _ in range(10):
            answer = await http.get("/health")
            if answer.is_error:  # it cannot even be read
                return str(answer.json()["detail"])
            if answer.json()["status"] != "ok":
                return str(answer.json()["fault"])
            await asyncio.sleep(0.1)
    return None


async def _until(acknowledged: Acknowledged, count: int) -> None:
    async with asyncio.timeout(_PATIENCE_S):
        while acknowledged.count < count:
            await asyncio.sleep(0.01)


def _fill(ballast: Path, left_open: int) -> None:
    room = shutil.disk_usage(ballast.parent).free - left_open
    with ballast.open("wb", buffering=0) as file, contextlib.suppress(OSError):
        for _ in range(max(0, room // _BLOCK)):
            file.write(os.urandom(_BLOCK))


def told(found: Filled) -> str:
    """Return what came of it, in words."""
    return (
        f"{found.runs} full disks: {found.acknowledged} deliveries of {found.readings} readings "
        f"acknowledged, {found.lost} lost, doubled or changed, {found.findings} findings; "
        f"{found.refused} refused meanwhile; the server ended {found.servers_ended} times; not said by "
        f"/health {found.unsaid} times; after room was made, acknowledged within {max(found.again_s):.1f} s, "
        f"median {np.median(found.again_s):.1f} s; load {min(found.load):.0f} to {max(found.load):.0f}\n"
    )


def main() -> int:
    """Run from the command line."""
    only_log = (False, "the server's data are elsewhere")
    wanted = study_options(__doc__, out=Path, runs=10, seed=0, only_log=only_log)
    disk = wanted.out.resolve()
    if shutil.disk_usage(disk).total > _LARGEST:
        raise SystemExit(f"{disk} is on a file system that is too large to be filled.")
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        Path(folder).chmod(0o755)
        os.environ["XDG_DATA_HOME"] = f"{folder}/beside"
        found = asyncio.run(
            full_server(disk, Path(folder), wanted.runs, wanted.seed, only_log=wanted.only_log)
        )
    for place in ("data", "log"):
        shutil.rmtree(disk / place, ignore_errors=True)
    leave(disk, "full_server", found)
    sys.stdout.write(told(found))
    return 0 if not found.lost + found.findings + found.unsaid else 1


if __name__ == "__main__":
    sys.exit(main())
