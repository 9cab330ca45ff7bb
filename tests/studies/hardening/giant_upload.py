"""Giant uploads beside a service at work: how long /health waits meanwhile, and how much memory they take.

`python -m tests.studies.hardening.giant_upload --out DIR [--rows N] [--runs N]` sends one giant campaign,
then four at once, to a service on a simulated cell, and asks for its health all the while.
"""

import asyncio
import contextlib
import io
import sys
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np

from tests.helpers.identification.synthetic import nominal_campaign
from tests.studies.running import leave, study_options
from truepose.demo.processes import SimulatedService, running_service
from truepose.exchange.campaigns.folder import campaign_files

ROWS = 1_000_000
_MODES = (1, 4)
_EVERY_S = 0.02
_MB = 2**20


@dataclass(frozen=True)
class Crowd:
    """What so many uploads at once did to the service."""

    uploads: int
    answers: tuple[int, ...]
    longest_answer_s: float
    health_asked: int
    health_median_s: float
    health_p99_s: float
    health_longest_s: float
    service_mb: float  # at most, resident
    with_workers_mb: float  # at most, resident


def giant_zip(rows=ROWS):
    """A campaign of so many rows in a zip of a few megabytes: the same readings over and over."""
    files = campaign_files(nominal_campaign(60))
    header, *given = files["calibration.csv"].splitlines()
    rest = [row.split(",", 1)[1] for row in given]
    numbered = (f"{number},{rest[number % len(rest)]}" for number in range(rows))
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("campaign.json", files["campaign.json"])
        archive.writestr("calibration.csv", "\n".join([header, *numbered, ""]))
    return stream.getvalue()


async def crowd(url, archive, uploads):
    """Send an archive so many times at once and watch the service meanwhile."""
    async with httpx.AsyncClient(base_url=url, timeout=300.0) as client:
        begun_s, waits, memory = time.perf_counter(), [], []
        sending = asyncio.gather(*(_sent(client, archive) for _ in range(uploads)))
        service = _listener(int(url.rsplit(":", 1)[1]))
        while not sending.done():
            asked_s = time.perf_counter()
            (await client.get("/health")).raise_for_status()
            waits.append(time.perf_counter() - asked_s)
            memory.append(_resident_mb(service))
            await asyncio.sleep(_EVERY_S)
        longest_s = time.perf_counter() - begun_s
    return Crowd(
        uploads=uploads,
        answers=tuple(sorted(await sending)),
        longest_answer_s=longest_s,
        health_asked=len(waits),
        health_median_s=float(np.median(waits)),
        health_p99_s=float(np.quantile(waits, 0.99)),
        health_longest_s=max(waits),
        service_mb=max(alone for alone, _ in memory),
        with_workers_mb=max(together for _, together in memory),
    )


async def _sent(client, archive):
    answer = await client.post(
        "/api/v1/campaigns", content=archive, headers={"Content-Type": "application/zip"}
    )
    return answer.status_code


def _listener(port):
    """The process that listens at a port of loopback."""
    inodes = {
        line.split()[9]
        for line in Path("/proc/net/tcp").read_text(encoding="utf-8").splitlines()[1:]
        if line.split()[1].endswith(f":{port:04X}") and line.split()[3] == "0A"
    }
    for handle in Path("/proc").glob("[0-9]*/fd/*"):
        with contextlib.suppress(OSError):
            if handle.readlink().name.removeprefix("socket:[").rstrip("]") in inodes:
                return int(handle.parts[2])
    raise LookupError(f"nobody listens at {port}")


def _resident_mb(service):
    """Resident memory of the service alone, and of all that it started but the simulated cell."""
    parents, resident, is_worker = {}, {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, IndexError):
            number = int(folder.name)
            parents[number] = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
            resident[number] = int((folder / "statm").read_text().split()[1]) * 4096 / _MB
            is_worker[number] = b"truepose.analysis.job_queue.worker" in (folder / "cmdline").read_bytes()
    workers = [n for n, parent in parents.items() if parent == service and is_worker.get(n)]
    return resident[service], resident[service] + sum(resident[n] for n in workers)


async def study(folder, rows=ROWS, runs=1, seed=0):
    """Run every mode `runs` times, on a service of its own each; returns what happened, one entry a mode."""
    archive = await asyncio.to_thread(giant_zip, rows)
    found = []
    for run in range(runs):
        for uploads in _MODES:
            name = f"{uploads}-{run}"
            cell = SimulatedService("irb120-clean", seed, folder / f"{name}.db", folder / f"{name}.log")
            async with running_service(cell) as url:
                found.append(await crowd(url, archive, uploads))
    return found, len(archive)


def main():
    options = study_options(__doc__, out=Path, rows=ROWS, runs=1, seed=0)
    options.out.mkdir(parents=True, exist_ok=True)
    found, size = asyncio.run(study(options.out, options.rows, options.runs, options.seed))
    leave(options.out, "giant_upload", {"rows": options.rows, "archive_bytes": size, "crowds": found})
    sys.stdout.write(f"{options.rows} rows, a zip of {size / _MB:.1f} MB\n{_HEAD}\n")
    sys.stdout.writelines(f"{_line(one)}\n" for one in found)


_HEAD = "uploads  answers            last answer s  health p50/p99/max ms   service MB  with workers MB"


def _line(one):
    waits = "/".join(
        f"{1e3 * wait_s:.0f}" for wait_s in (one.health_median_s, one.health_p99_s, one.health_longest_s)
    )
    answers = ",".join(map(str, one.answers))
    return (
        f"{one.uploads:7d}  {answers:17s}  {one.longest_answer_s:13.1f}  {waits:22s}  "
        f"{one.service_mb:10.0f}  {one.with_workers_mb:15.0f}"
    )


if __name__ == "__main__":
    main()
