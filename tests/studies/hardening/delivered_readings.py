"""Durable readings over HTTP: sixteen programs deliver to a service that has one core of its own.

`python -m tests.studies.hardening.delivered_readings --out DIR [--seconds N] [--clients N] [--database URL]`.
Clients, and a server of PostgreSQL that the study starts, have the other cores. Each client sends its next
delivery once the last one was answered, which is when it is on disk. After a second to warm up, rounds of one
reading a request and of ten alternate. At the end every reading that was answered is read back. Both engines
take two minutes.
"""

import asyncio
import json
import os
import statistics
import subprocess
import sys
import time
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

import httpx

from tests.helpers.postgresql.server import own_server, programs
from tests.studies.processes import cpu_s
from tests.studies.running import leave, study_parser

CORE = 0
ROUNDS = 3
SIZES = (1, 10)
WARM_S = 1.0
COLUMNS = [f"q{joint} [deg]" for joint in range(1, 7)] + ["x [mm]", "y [mm]", "z [mm]"]


@dataclass(frozen=True)
class Delivered:
    """What one round came to."""

    database: str
    together: int  # readings of one request
    readings_per_s: float
    p50_ms: float
    p99_ms: float
    cpu_ms: float  # of the service, a request
    busy: float  # share of its core that the service had
    load: float  # of the machine, over the last minute, before


@contextmanager
def _databases(folder):
    """Yield the address of a new file, and of a database on a server of its own where one is installed."""
    file = (folder / f"delivered-{time.time_ns()}.sqlite3").resolve()
    if programs() is None:
        sys.stdout.write("no PostgreSQL is installed here\n")
        yield [f"sqlite:///{file}"]
        return
    with own_server() as server:
        yield [f"sqlite:///{file}", server.make("delivered", "template1")]


@contextmanager
def _service(url):
    command = [sys.executable, "-m", "truepose", "serve", "--no-accounts", "--port", "0", "--database", url]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        os.sched_setaffinity(process.pid, {CORE})
        try:
            yield process, json.loads(process.stdout.readline())["url"]
        finally:
            process.terminate()


class _Client:
    """One program, with one connection; plain streams, so that it leaves the other core to its neighbours."""

    def __init__(self, url, series):
        self._address = url.removeprefix("http://").split(":")
        self._path = f"/api/v1/series/{series}/readings"
        self.series, self.answered, self.waits_s = series, 0, []

    async def deliver(self, seconds, together):
        host, port = self._address
        reader, writer = await asyncio.open_connection(host, int(port))
        end_s = time.perf_counter() + seconds
        while (begun_s := time.perf_counter()) < end_s:
            writer.write(self._request(f"{host}:{port}", together))
            head = await reader.readuntil(b"\r\n\r\n")
            if not head.startswith(b"HTTP/1.1 201"):
                raise RuntimeError(head.decode())
            await reader.readexactly(_length(head))
            self.answered += together
            self.waits_s.append(time.perf_counter() - begun_s)
        writer.close()

    def _request(self, host, together):
        first = self.answered + 1
        rows = [_reading(self.series, number) for number in range(first, first + together)]
        body = json.dumps({"first": first, "readings": rows}).encode()
        head = (
            f"POST {self._path} HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\n"
            f"Content-Length: {len(body)}\r\n\r\n"
        )
        return head.encode() + body


def _length(head):
    lines = head.lower().split(b"\r\n")
    return next(int(line.partition(b":")[2]) for line in lines if line.startswith(b"content-length:"))


def _reading(series, number):
    return [round(0.001 * number * joint, 6) for joint in range(1, 7)] + [500.125, series, number]


def _round(process, clients, seconds, together):
    for client in clients:
        client.waits_s.clear()
    load, used_s, before = os.getloadavg()[0], cpu_s(process.pid), sum(client.answered for client in clients)
    begun_s = time.perf_counter()

    async def all_of_them():
        await asyncio.gather(*(client.deliver(seconds, together) for client in clients))

    asyncio.run(all_of_them())
    taken_s = time.perf_counter() - begun_s
    used_s = cpu_s(process.pid) - used_s
    waits_ms = [1000 * wait_s for client in clients for wait_s in client.waits_s]
    quantiles = statistics.quantiles(waits_ms, n=100)
    return {
        "together": together,
        "readings_per_s": (sum(client.answered for client in clients) - before) / taken_s,
        "p50_ms": quantiles[49],
        "p99_ms": quantiles[98],
        "cpu_ms": 1000 * used_s / len(waits_ms),
        "busy": used_s / taken_s,
        "load": load,
    }


def _read_back(http, client):
    """Raise where a reading that was answered is not there, or another one is."""
    kept, after = [], 0
    while page := http.get(f"/series/{client.series}/readings", params={"after": after, "limit": 500}).json():
        kept += page
        after = page[-1]["number"]
    expected = [_reading(client.series, number) for number in range(1, client.answered + 1)]
    if [one["values"] for one in kept] != expected:
        raise RuntimeError(f"series {client.series}: {len(kept)} kept, {client.answered} were answered")


def delivered(database, clients, seconds):
    """Return what each round came to, once all that was answered was found again."""
    with (
        _service(database) as (process, url),
        httpx.Client(base_url=f"{url}/api/v1", trust_env=False, timeout=60) as http,
    ):
        begun = [http.post("/series", json={"name": "study", "columns": COLUMNS}) for _ in range(clients)]
        delivering = [_Client(url, answer.json()["id"]) for answer in begun]
        _round(process, delivering, WARM_S, 1)
        rounds = [_round(process, delivering, seconds, size) for _ in range(ROUNDS) for size in SIZES]
        for one in delivering:
            _read_back(http, one)
    name = database.partition(":")[0].partition("+")[0]
    return [Delivered(database=name, **one) for one in rounds]


def _shown(found):
    for one in found:
        sys.stdout.write(
            f"{one.database}, {one.together} a request: {one.readings_per_s:,.0f} readings a second, median "
            f"{one.p50_ms:.1f} ms, p99 {one.p99_ms:.1f} ms, {one.cpu_ms:.2f} ms of CPU a request, "
            f"{one.busy:.0%} of its core, load {one.load:.1f}\n"
        )
    sys.stdout.flush()
    return found


def main():
    """Run the study."""
    parser = study_parser(__doc__, out=Path, seconds=(8.0, "of each round"), clients=16)
    parser.add_argument("--database", help="the default: a new file in DIR, and a server of its own")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    os.sched_setaffinity(0, os.sched_getaffinity(0) - {CORE})
    os.environ["XDG_DATA_HOME"] = str(options.out.resolve())  # where what belongs to a server's lies
    asked = nullcontext([options.database]) if options.database else _databases(options.out)
    with asked as urls:
        found = [one for url in urls for one in _shown(delivered(url, options.clients, options.seconds))]
    leave(options.out, "delivered_readings", found)


if __name__ == "__main__":
    main()
