"""A simulated controller streams its joints over UDP: to the driver, and to a client that others wrote."""

import asyncio
import contextlib
import importlib
import socket
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.machine import ABB_ROBOT_CLIENT
from truepose_drivers.abb_egm.reader import EgmReader
from truepose_drivers.errors import ConnectFailedError
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.udp import UdpPort
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import LinkHalfOpen
from truepose_simulators.instruments.cable import FaultyCable
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController
from truepose_simulators.instruments.robot.abb_rws.egm_stream import EgmStream
from truepose_simulators.scenarios.file import load_scenario

TARGET_DEG = (10.12345678, -20.0, 15.0, 30.0, 40.0, -50.0)


def free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@contextlib.asynccontextmanager
async def streaming(port):
    """Have a controller stream to a port; yields its cell and the stream."""
    cell = Cell(replace(load_scenario("irb120-clean"), noise=False), 1, CellClock(0))
    stream = EgmStream(AbbController(cell), port)
    stream.cable = FaultyCable(stream.device, cell.faults, cell.clock)
    address = await stream.open("127.0.0.1", 0)
    assert (address.device, address.protocol, address.port) == ("robot-egm", "egm", port)
    try:
        yield cell, stream
    finally:
        await stream.close()


async def move(cell):
    await cell.move_robot([np.radians(TARGET_DEG)], SpeedLimits(), np.zeros(3))


async def test_the_driver_reads_every_digit_and_a_stream_that_is_cut_is_lost():
    port = free_udp_port()
    reader = EgmReader(UdpPort("127.0.0.1", port), MonotonicClock())
    async with streaming(port) as (cell, _):
        await reader.connect()
        await move(cell)
        assert np.degrees((await reader.read_joints()).joints_rad) == pytest.approx(TARGET_DEG, abs=1e-12)

        cell.add_fault(LinkHalfOpen(device="robot"))
        with pytest.raises(ConnectFailedError, match=f"UDP port {port} from 127.0.0.1"):
            await reader.connect()
        assert not reader.connected


async def test_what_another_machine_sends_is_none_of_the_robots():
    port = free_udp_port()
    reader = EgmReader(UdpPort("127.0.0.2", port), MonotonicClock())

    async with streaming(port):
        with pytest.raises(ConnectFailedError, match="no new data arrives"):
            await reader.connect()


async def test_a_port_that_another_program_has_is_said():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("0.0.0.0", 0))
        port = other.getsockname()[1]
        with pytest.raises(ConnectFailedError, match=rf"cannot listen at UDP port {port}.*no other program"):
            await UdpPort("127.0.0.1", port).open()


async def test_the_python_client_of_others_reads_joints_and_states():
    pytest.importorskip("abb_robot_client.egm", reason=ABB_ROBOT_CLIENT.reason)
    port = free_udp_port()
    client = importlib.import_module("abb_robot_client.egm").EGM(port=port)
    async with streaming(port) as (cell, _):
        await move(cell)
        await asyncio.to_thread(client.receive_from_robot, 5.0)
        while (await asyncio.to_thread(client.receive_from_robot, 0.0))[0]:
            pass
        heard, state = await asyncio.to_thread(client.receive_from_robot, 5.0)
        answered = client.send_to_robot([0.0] * 6)
    client.close()

    assert heard and answered
    assert state.joint_angles == pytest.approx(TARGET_DEG)
    assert (state.motors_on, state.rapid_running) == (True, True)
