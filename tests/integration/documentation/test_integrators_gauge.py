"""The gauge that docs/integrator.md writes from scratch keeps the contract, and measures in a session."""

import asyncio
import os
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import client_of
from tests.integration.web.ballbar_bench import SESSIONS, WANTED, Tablet
from tests.integration.web.bench import CELL, Bench
from truepose.app import create_app
from truepose.settings import Settings
from truepose_drivers.contract.cases import CASES
from truepose_drivers.registry import ENTRY_POINT_GROUP, DriverRegistry, load_registry

_FOLDER = Path(__file__).parents[3] / "docs" / "examples" / "acme_gauge"
_MOST_LINES = 120  # driver, bench and project together
_OWN, _OTHER = "1001", "2002"
_BALLBAR = f"""
[ballbar]
base_points = 3

[ballbar.instrument]
name = "ACME G1"
serial_number = "{_OWN}"
certificate = "report 12"

[[device]]
name = "ballbar"
driver = "acme_gauge"
host = "127.0.0.1"
port = %d

[[device]]
name = "hands"
driver = "fake_hands"
"""


@pytest.fixture
def gauge_bench(monkeypatch):
    """The bench of the example, importable as if it were installed."""
    monkeypatch.syspath_prepend(str(_FOLDER))
    from acme_gauge_bench import AcmeGaugeBench

    yield AcmeGaugeBench
    for name in ("acme_gauge", "acme_gauge_bench"):
        sys.modules.pop(name)


def installed(group):
    project = tomllib.loads((_FOLDER / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return [EntryPoint(name, value, group) for name, value in project["entry-points"][group].items()]


def test_the_gauge_is_written_in_a_hundred_and_twenty_lines():
    files = [file for file in _FOLDER.iterdir() if file.is_file()]

    assert sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files) <= _MOST_LINES


def test_its_project_names_driver_and_bench(gauge_bench):
    (bench,) = installed("truepose.driver_benches")

    assert load_registry(installed(ENTRY_POINT_GROUP)).names("ballbar") == ("acme_gauge",)
    assert bench.load() is gauge_bench


def install(folder, project):
    """Register the entry points of a project in a folder of packages, as an installation does."""
    table = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
    registered = folder / f"{table['name'].replace('-', '_')}_here-1.dist-info"
    registered.mkdir(parents=True)
    (registered / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {table['name']}-here\nVersion: 1\n")
    groups = [
        "\n".join([f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())])
        for group, entries in table["entry-points"].items()
    ]
    (registered / "entry_points.txt").write_text("\n".join(groups) + "\n")


async def test_it_keeps_the_contract_by_the_command_of_the_page(tmp_path):
    """In a process of its own, away from this repository."""
    for project in (_FOLDER, _FOLDER.parents[2]):
        install(tmp_path / "packages", project / "pyproject.toml")
    command = ["--pyargs", "truepose_drivers.contract", "--driver", "acme_gauge"]
    shorter = ["--hostile-answers", "20", "--link-faults", "5", "-p", "no:cacheprovider"]

    asked = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "pytest", *command, *shorter),
        stdout=asyncio.subprocess.PIPE,
        cwd=tmp_path,
        env={"PYTHONPATH": os.pathsep.join([str(tmp_path / "packages"), str(_FOLDER), *sys.path])},
    )
    said = (await asked.communicate())[0].decode()

    assert asked.returncode == 0, said
    table = dict(line.rsplit(maxsplit=1) for line in said.splitlines() if line.endswith(("yes", " -", "NO")))
    not_asked = {case for case, kept in table.items() if kept == "-"}
    assert len(table) == len(CASES) + 3  # hostile bytes, hostile answers, faults of the link
    assert "a_frozen_device_gives_no_reading" not in not_asked
    assert "acme_gauge: it has no keys, and serves one program at a time" in said


class SimulatedGauge:
    """A gauge of the bench, behind a socket."""

    def __init__(self, gauge):
        self.gauge = gauge
        self._writers = []

    async def __aenter__(self):
        self._server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(self, *_):
        self._server.close()
        self.hang_up()

    def hang_up(self):
        while self._writers:
            self._writers.pop().close()

    async def _serve(self, reader, writer):
        self._writers.append(writer)
        while line := await reader.readline():
            writer.writelines(self.gauge.answer(line))


@pytest.fixture
async def simulated(gauge_bench):
    async with SimulatedGauge(gauge_bench()) as gauge:
        yield gauge


@pytest.fixture
async def tablet(tmp_path, simulated):
    """A person at a cell whose ballbar is the gauge of the example."""
    (tmp_path / "cell.toml").write_text(CELL + _BALLBAR % simulated.port)
    settings = Settings(f"sqlite:///{tmp_path / 'kept.sqlite3'}", cell_file=tmp_path / "cell.toml")
    theirs = load_registry(installed(ENTRY_POINT_GROUP))
    registry = DriverRegistry({**Bench().registry().plugins, **theirs.plugins}, {})
    application = create_app(settings, registry)
    async with application.router.lifespan_context(application), client_of(application) as client:
        created = await client.post(SESSIONS, json=WANTED)
        assert created.status_code == 201, created.text
        yield Tablet(client)


async def measured(tablet, step_id):
    """Store the length of a step, and return the line of the ledger that keeps it."""
    async with asyncio.timeout(HANGS_S):
        while True:
            found = [one for one in await tablet.ledger() if one["kind"] == "measured"]
            if found and found[-1]["step_id"] == step_id:
                return found[-1]["length"]
            await tablet.press("store", step_id=step_id)


async def test_it_measures_in_a_ballbar_session(tablet, simulated):
    simulated.gauge.true_mm = 0.0123
    await tablet.press("start")

    length = await measured(tablet, "tool/initialise")

    assert length["deviation_mm"] == pytest.approx(0.0123, abs=1e-9)
    assert (length["instrument_serial"], length["certificate"]) == (_OWN, "report 12")


async def test_another_gauge_at_its_address_is_refused_until_a_person_accepts_it(tablet, simulated):
    await tablet.press("start")
    await measured(tablet, "tool/initialise")
    simulated.gauge.serial = _OTHER
    simulated.hang_up()

    async with asyncio.timeout(HANGS_S):
        while (seen := await tablet.see())["ballbar_in_question"] is None:
            await tablet.press({"paused": "resume"}.get(seen["state"], "store"))
    kept = len([one for one in await tablet.ledger() if one["kind"] == "measured"])
    refused = await tablet.press("confirm")
    still = len([one for one in await tablet.ledger() if one["kind"] == "measured"])
    accepted = await tablet.press("confirm", accept_serial_number=_OTHER)
    length = await measured(tablet, (await tablet.see())["step"]["id"])

    assert refused.status_code == 409
    assert still == kept == 1
    assert accepted.status_code == 200, accepted.text
    assert (length["instrument_serial"], length["certificate"]) == (_OTHER, "")
