"""The instruments of a simulated cell as devices of the service."""

import asyncio
from pathlib import Path

import pytest

from tests.contract.benches import registry
from tests.helpers.machine import HANGS_S
from truepose.app import simulation
from truepose.app.composition import _with_simulated_devices
from truepose.app.simulation import Simulation
from truepose.exchange.cells.file import simulated_cell
from truepose.web.context import Endpoint
from truepose_drivers.errors import ConnectionLostError

TOOL_FILE = Path("artefact.rom")


def devices_of(*announced: tuple[str, str, int]):
    endpoints = tuple(Endpoint(device, protocol, "127.0.0.1", port) for device, protocol, port in announced)
    cell = _with_simulated_devices(
        simulated_cell("ur10-clean", 1), Simulation(None, endpoints, TOOL_FILE), registry()
    )
    return {device.name: (device.driver, dict(device.options)) for device in cell.devices}


def test_a_device_that_listens_at_several_ports_is_given_all_of_them():
    found = devices_of(
        ("tracker", "emscon", 1),
        ("robot", "ur_rtde", 2),
        ("robot-script", "ur_script", 3),
        ("robot-dashboard", "ur_dashboard", 4),
    )

    ports = {"host": "127.0.0.1", "port": 2, "script_port": 3, "dashboard_port": 4}
    assert found["robot"] == ("universal_robots", ports)
    assert found["tracker"] == ("leica_emscon", {"host": "127.0.0.1", "port": 1})


def test_a_fanuc_is_asked_at_the_simulated_logger_while_it_moves():
    found = devices_of(("robot", "mappdk", 2), ("robot-logger", "mappdk_log", 3))

    assert found == {"robot": ("fanuc_mappdk", {"host": "127.0.0.1", "port": 2, "logger_port": 3})}


def test_a_port_that_the_driver_does_not_know_is_left_out():
    found = devices_of(("robot", "open_abb", 2), ("robot-camera", "rtsp", 3))

    assert found == {"robot": ("abb_open_abb", {"host": "127.0.0.1", "port": 2})}


def test_an_abb_is_seen_moving_at_the_simulated_logger():
    found = devices_of(("robot", "open_abb", 2), ("robot-log", "open_abb_log", 3))

    assert found == {"robot": ("abb_open_abb", {"host": "127.0.0.1", "port": 2, "log_port": 3})}


def test_a_camera_is_brought_the_definition_of_the_simulated_artefact():
    found = devices_of(("camera", "ndi", 4))

    assert found == {"camera": ("ndi_polaris", {"host": "127.0.0.1", "port": 4, "tool_file": "artefact.rom"})}


def test_an_abb_is_watched_and_read_at_the_further_ports_of_its_controller():
    found = devices_of(("robot", "open_abb", 2), ("robot-rws", "rws", 3), ("robot-egm", "egm", 6510))

    ports = {"host": "127.0.0.1", "port": 2, "rws_port": 3, "egm_port": 6510}
    assert found == {"robot": ("abb_open_abb", ports)}


def test_an_abb_without_sockets_is_driven_over_its_web_services():
    found = devices_of(("robot", "rws", 2))

    assert found == {"robot": ("abb_rws", {"host": "127.0.0.1", "port": 2})}


async def test_a_question_that_is_not_answered_leaves_no_connection_behind(monkeypatch):
    monkeypatch.setattr(simulation, "_ANSWER_S", 0.01)
    ended = asyncio.Event()

    async def listen(reader, writer):
        while await reader.read(100):  # never answers
            pass
        ended.set()
        writer.close()

    async with await asyncio.start_server(listen, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        cell = Simulation(None, (Endpoint("faults", "faults", "127.0.0.1", port),), TOOL_FILE)
        with pytest.raises(ConnectionLostError):
            await cell.ask_of_faults({"ask": "kinds"})

        await asyncio.wait_for(ended.wait(), HANGS_S)
    assert ended.is_set()
