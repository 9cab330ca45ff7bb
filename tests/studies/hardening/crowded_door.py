"""A session goes on while a crowd stands in the door: silent, slow and deaf connections, and giant uploads.

`python -m tests.studies.hardening.crowded_door --out DIR [--silent N] [--slow N] [--uploads N] [--runs N]`
starts the service as `truepose serve` does, on a simulated cell in real time, with a session under way.
Each health, pause and abort comes over a connection of its own, as that of somebody who has just opened a
page.
"""

import asyncio
import contextlib
import json
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np

from tests.studies.hardening.giant_upload import ROWS, _listener, _resident_mb, _sent, giant_zip
from tests.studies.running import leave, study_options

_EVERY_S = 0.05
_PATIENCE_S = 60.0
_SESSION = "/api/v1/sessions/1"
_PERSON = {"person": "Ada Byron"}


@dataclass(frozen=True)
class Crowded:
    """What the crowd did to the session and to whoever asked."""

    silent: int
    slow: int
    uploads: tuple[int, ...]  # their answers
    health_asked: int
    health_failed: int
    health_p50_s: float
    health_p99_s: float
    health_longest_s: float
    pause_s: float
    abort_s: float
    states: tuple[str, ...]  # of the session, from its confirmation on
    interruptions: int  # states that nobody asked for
    with_workers_mb: float  # at most, resident
    log_lines: int
    kept: dict  # by kind of connection: how many were closed, and the longest that one was kept


@contextlib.asynccontextmanager
async def _service(folder, name):
    """Start the service and yield its URL and where its log is."""
    log = folder / f"{name}.log"
    with log.open("wb") as errors, tempfile.TemporaryDirectory(dir=folder) as fresh:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "truepose", "serve", "--port", "0"),
            *("--database", f"sqlite:///{fresh}/truepose.db"),
            stdout=asyncio.subprocess.PIPE,
            stderr=errors,
        )
        try:
            yield json.loads(await process.stdout.readline())["url"], log
        finally:
            process.terminate()
            await process.wait()


async def _asked(url, method, path, **more):
    """Ask over a connection of its own; returns the answer and how long it took."""
    # Without TLS: reading its certificates would take longer than the answer.
    client = httpx.AsyncClient(base_url=url, timeout=_PATIENCE_S, trust_env=False, verify=False)
    async with client:
        begun_s = time.perf_counter()
        answer = await client.request(method, path, **more)
        return answer, time.perf_counter() - begun_s


async def _session_under_way(url):
    for device in ("tracker", "robot"):
        (await _asked(url, "POST", f"/api/v1/devices/{device}/connect"))[0].raise_for_status()
    joints = [[5.0 * k, 40.0, -30.0, 5.0 * k, 30.0, 0.0] for k in range(-18, 18)]
    stops = [{"config": k, "joints_deg": q, "nest": 1} for k, q in enumerate(joints, 1)]
    wanted = {"name": "crowded", "role": "calibration", "plan": {"method": "given", "stops": stops}}
    (await _asked(url, "POST", "/api/v1/sessions", json=wanted))[0].raise_for_status()
    for command in ("start", "confirm"):
        found = (await _asked(url, "GET", f"{_SESSION}/situation"))[0].json()
        said = {"command": command, "prompt_id": (found["prompt"] or {}).get("id"), **_PERSON}
        (await _asked(url, "POST", f"{_SESSION}/commands", json=said))[0].raise_for_status()


async def _health(url, asked):
    """Ask for health so often; returns how long each answer took, infinite where there was none."""
    waits = []
    for _ in range(asked):
        try:
            answer, wait_s = await _asked(url, "GET", "/health")
            waits.append(wait_s if answer.is_success else float("inf"))
        except httpx.TransportError:
            waits.append(float("inf"))
        await asyncio.sleep(_EVERY_S)
    return waits


async def _memory(service, most_mb):
    while True:
        most_mb.append((await asyncio.to_thread(_resident_mb, service))[1])
        await asyncio.sleep(1.0)


async def _crowd(url, seconds, silent, slow):
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "tests.studies.hardening.crowd", url.rsplit(":", 1)[1]),
        *(str(seconds), str(silent), str(slow)),
        stdout=asyncio.subprocess.PIPE,
    )
    told, _ = await process.communicate()
    return json.loads(told)


async def _states(url):
    """Return the states of the session since it was confirmed, each change once."""
    wanted = {"session_id": 1, "stop_after_s": 2}
    answer, _ = await _asked(url, "GET", "/api/v1/events", params=wanted)
    said = [line.removeprefix("data: ") for line in answer.text.splitlines() if line.startswith("data: ")]
    states = [document["state"] for document in map(json.loads, said) if "state" in document]
    return tuple(states[states.index("running") :])


async def crowded(folder, name, archive, *, silent, slow, uploads, asked, seconds):
    """Run a session in a crowd; returns what happened."""
    most_mb, sizes = [], {"silent": silent, "slow": slow}
    async with _service(folder, name) as (url, log):
        await _session_under_way(url)
        memory = asyncio.create_task(_memory(_listener(int(url.rsplit(":", 1)[1])), most_mb))
        around = asyncio.create_task(_crowd(url, seconds, silent, slow))
        async with httpx.AsyncClient(base_url=url, timeout=300.0, trust_env=False) as sender:
            sending = asyncio.gather(*(_sent(sender, archive) for _ in range(uploads)))
            waits = await _health(url, asked)
            paused, pause_s = await _asked(url, "POST", f"{_SESSION}/commands", json={"command": "pause"})
            waits += await _health(url, asked // 2)
            aborted, abort_s = await _asked(url, "POST", f"{_SESSION}/commands", json={"command": "abort"})
            answers, kept = tuple(sorted(await sending)), await around
        memory.cancel()
        states = await _states(url)
    expected = ("running", "pausing", "paused", "aborting", "aborted")
    if not (paused.is_success and aborted.is_success):
        states = (*states, "refused")
    return Crowded(
        **sizes,
        uploads=answers,
        health_asked=len(waits),
        health_failed=sum(not np.isfinite(wait_s) for wait_s in waits),
        health_p50_s=float(np.quantile(waits, 0.5, method="higher")),
        health_p99_s=float(np.quantile(waits, 0.99, method="higher")),
        health_longest_s=max(waits),
        pause_s=pause_s,
        abort_s=abort_s,
        states=states,
        interruptions=sum(state not in expected for state in states),
        with_workers_mb=max(most_mb),
        log_lines=len(log.read_bytes().splitlines()),
        kept=kept,
    )


def main():
    options = study_options(
        __doc__,
        out=Path,
        silent=1100,
        slow=500,
        uploads=4,
        rows=ROWS,
        runs=1,
        asked=(200, "How often for health before the pause."),
        seconds=(60.0, "How long the crowd stays."),
    )
    options.out.mkdir(parents=True, exist_ok=True)
    found = asyncio.run(_runs(options))
    leave(options.out, "crowded_door", found)
    sys.stdout.writelines(f"{_told(one)}\n" for one in found)


async def _runs(options):
    archive = await asyncio.to_thread(giant_zip, options.rows)
    of = {name: getattr(options, name) for name in ("silent", "slow", "uploads", "asked", "seconds")}
    return [await crowded(options.out, f"run-{run}", archive, **of) for run in range(options.runs)]


def _told(one):
    lines = [
        f"{one.silent} silent, {one.slow} slow, uploads answered {one.uploads}",
        f"  health: {one.health_asked} asked, {one.health_failed} failed, p50 {one.health_p50_s:.3f} s, "
        f"p99 {one.health_p99_s:.3f} s, longest {one.health_longest_s:.3f} s",
        f"  pause {one.pause_s:.3f} s, abort {one.abort_s:.3f} s, session {' > '.join(one.states)}, "
        f"{one.interruptions} interruptions",
        f"  memory {one.with_workers_mb:.0f} MB, log {one.log_lines} lines",
        *(f"  {kind}: {told['closed']} closed, kept {told['longest_s']:.1f} s at most"
          for kind, told in sorted(one.kept.items())),
    ]  # fmt: skip
    return "\n".join(lines)


if __name__ == "__main__":
    main()
