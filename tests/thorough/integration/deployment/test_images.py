"""Every command of compose file and Dockerfiles, executed in a plain environment with free ports."""

import json
import socket

import httpx
import numpy as np
import pytest

from tests.helpers.ports import free_block, free_port
from tests.integration.deployment.deployment_files import CHECKOUT, compose_file, dockerfiles
from tests.thorough.integration.deployment.images import (
    CONSECUTIVE_PORTS,
    announced,
    copy_sources,
    environment,
    healthy,
    install,
    networked_cell,
    on_this_interpreter,
    replaced,
    running,
)
from truepose.exchange.cells.file import read_cell

_SERVICES = compose_file()["services"]
_ANYWHERE, _HERE = "0.0.0.0", "127.0.0.1"
_DATA, _CELL_FILE = "/var/lib/truepose", "/etc/truepose/cell.toml"
_PAGES = ("/", "/docs", "/openapi.json", "/api/v1/sessions")
_ENDPOINTS = ("tracker", "robot", "robot-log", "clock", "truth", "ballbar", "ballbar", "ballbar", "hands")


@pytest.fixture(scope="module")
def cell_image(tmp_path_factory):
    return copy_sources(dockerfiles()["cell"], tmp_path_factory.mktemp("cell-image"))


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The programs of a fresh environment into which the service's image was installed as a wheel."""
    source = copy_sources(dockerfiles()["service"], tmp_path_factory.mktemp("service-image"))
    return install(source, tmp_path_factory.mktemp("installed"))


@pytest.fixture(scope="module")
def running_cell(cell_image):
    """The cell as the compose file starts it; yields its first port and what it announced."""
    first = free_block(CONSECUTIVE_PORTS)
    command = replaced(_SERVICES["cell"]["command"], {_ANYWHERE: _HERE, "7000": str(first)})
    with running(on_this_interpreter(command), cell_image, environment()) as stdout:
        yield first, announced(stdout, len(_ENDPOINTS))


def test_the_simulators_image_runs_without_the_service(cell_image):
    command = replaced(
        dockerfiles()["cell"].command(), {_ANYWHERE: _HERE, "7000": str(free_block(CONSECUTIVE_PORTS))}
    )

    with running(on_this_interpreter(command), cell_image, environment()) as stdout:
        endpoints = announced(stdout, len(_ENDPOINTS))

    assert tuple(endpoint["device"] for endpoint in endpoints) == _ENDPOINTS
    assert not (cell_image / "service").exists()


def test_the_cell_puts_every_device_on_the_port_that_the_files_count_on(running_cell):
    first, endpoints = running_cell

    offsets = [endpoint["port"] - first for endpoint in endpoints]

    (exposed,) = dockerfiles()["cell"].all("EXPOSE")
    assert exposed.split() == [str(7000 + offset) for offset in offsets]
    assert offsets[_ENDPOINTS.index("clock")] == 3  # what the health check asks


def test_the_cell_files_notes_on_where_the_nests_are_belong_to_this_cell(running_cell):
    first, _ = running_cell
    noted = read_cell(CHECKOUT / "docs" / "examples" / "networked-cell.toml").fixed_nests_seen_mm

    with socket.create_connection((_HERE, first + 4), timeout=5.0) as truth:
        truth.sendall(b'{"op": "aim"}\n')
        seen = json.loads(truth.makefile().readline())["fixed_nests_seen_from_tracker_mm"]

    # An aim is rounded to 20 mm here and there; the tracker looks within 50 mm of it.
    assert np.array(noted) == pytest.approx(np.array(seen), abs=20.0)


def test_the_cells_health_check_tells_a_running_cell_from_none(running_cell, cell_image):
    first, _ = running_cell
    test = _SERVICES["cell"]["healthcheck"]["test"]

    alive = healthy(replaced(test, {"7003": str(first + 3)}), None, environment(), cell_image)
    absent = healthy(replaced(test, {"7003": str(free_port())}), None, environment(), cell_image)

    assert (alive, absent) == (True, False)


def test_the_installed_service_reaches_the_networked_cell_through_its_cell_file(
    running_cell, programs, tmp_path
):
    first, _ = running_cell
    port = free_port()
    cell_file = networked_cell(tmp_path, first)
    command = replaced(
        _SERVICES["service"]["command"],
        {_ANYWHERE: _HERE, "8000": str(port), _DATA: str(tmp_path), _CELL_FILE: str(cell_file)},
    )

    with running(on_this_interpreter(command, programs), tmp_path, environment()) as stdout:
        (ready,) = announced(stdout)
        with httpx.Client(base_url=ready["url"], timeout=20.0) as client:
            devices = {name: client.post(f"/api/v1/devices/{name}/connect") for name in ("tracker", "robot")}
            health = client.get("/health").json()

    assert {name: reply.status_code for name, reply in devices.items()} == {"tracker": 200, "robot": 200}
    assert all(reply.json()["connected"] for reply in devices.values())
    assert health["status"] == "ok"
    assert (tmp_path / "truepose.sqlite3").is_file()


def test_the_installed_service_alone_creates_its_schema_pages_and_simulated_cell(programs, tmp_path):
    port = free_port()
    command = replaced(
        dockerfiles()["service"].command(), {_ANYWHERE: _HERE, "8000": str(port), _DATA: str(tmp_path)}
    )
    test = replaced(_SERVICES["service"]["healthcheck"]["test"], {"8000": str(port)})

    before = healthy(test, programs, environment(), tmp_path)
    with running(on_this_interpreter(command, programs), tmp_path, environment()) as stdout:
        (ready,) = announced(stdout)
        with httpx.Client(base_url=ready["url"], timeout=20.0) as client:
            health = client.get("/health").json()
            pages = [
                client.get(path).status_code for path in ("/", "/docs", "/openapi.json", "/api/v1/sessions")
            ]
            robots = client.get("/api/v1/robots").json()
        during = healthy(test, programs, environment(), tmp_path)

    assert (before, during) == (False, True)
    assert health["simulated"] is True
    assert health["schema"]
    assert pages == [200] * len(_PAGES)
    assert len(robots) == 4
