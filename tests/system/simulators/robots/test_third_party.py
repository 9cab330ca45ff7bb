"""Clients by others, unchanged, against a simulated tracker and a simulated robot controller."""

import asyncio
import contextlib
import importlib
import threading
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.machine import ABB_ROBOT_CLIENT, CESAPI
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.leica_emscon.server import tracker_endpoint
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, PublicProgram
from truepose_simulators.instruments.robot.abb_rws.server import web_endpoint
from truepose_simulators.scenarios.file import load_scenario


@contextlib.contextmanager
def served(make_endpoint):
    """Serve an instrument of a cell from another thread, since these clients block; yields its port."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    cell = Cell(replace(load_scenario("irb120-tilted")), 1, CellClock(0))
    endpoint = make_endpoint(cell)
    address = asyncio.run_coroutine_threadsafe(endpoint.open("127.0.0.1", 0), loop).result()
    yield address.port
    asyncio.run_coroutine_threadsafe(endpoint.close(), loop).result()
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


@pytest.fixture
def port():
    """Port of a tracker."""
    with served(tracker_endpoint) as at:
        yield at


def irc5_with_the_usual_program(cell):
    controller = AbbController(cell)
    controller.task = PublicProgram(controller)
    return web_endpoint(cell, controller)


def test_the_python_client_of_abb_robots_reads_moves_and_is_told_errors():
    rws = pytest.importorskip("abb_robot_client.rws", reason=ABB_ROBOT_CLIENT.reason)
    with served(irc5_with_the_usual_program) as at:
        client = rws.RWS(f"http://127.0.0.1:{at}")
        states = (client.get_controller_state(), client.get_operation_mode(), client.get_speedratio())
        client.stop()
        client.resetpp()
        client.start(cycle="once")
        target_rad = np.radians([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
        client.set_rapid_variable_jointtarget("tgt", rws.JointTarget(target_rad, np.zeros(6)))
        client.set_rapid_variable_num("go", 1)
        while client.get_rapid_variable_num("go"):
            pass
        joints_deg = client.get_jointtarget().robax
        with pytest.raises(rws.ABBException, match="nothing not found"):
            client.get_rapid_variable("nothing")
        client.set_controller_state("motoroff")
        with pytest.raises(rws.ABBException, match="motors are off"):
            client.start()
        log = client.read_event_log()
        client.close()

    assert states == ("motoron", "AUTO", 100.0)
    assert joints_deg == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], abs=1e-5)
    assert log[-1].title == "motoroff"


def test_the_python_client_cesapi_measures_and_is_told_errors(port):
    pytest.importorskip("CESAPI", reason=CESAPI.reason)
    packets = importlib.import_module("CESAPI.packet")
    connection = importlib.import_module("CESAPI.connection").Connection()
    connection.connect(host="127.0.0.1", port=port)
    command = importlib.import_module("CESAPI.command").CommandSync(connection)
    try:
        with pytest.raises(Exception, match="Command 54 failed with status 39"):
            command.GoBirdBath()
        units = packets.SystemUnitsDataT()
        units.lenUnitType = packets.ES_LU_Millimeter
        command.SetUnits(units)
        command.Initialize()
        mode = packets.StationaryModeDataT()
        mode.lMeasTime = 1000
        command.SetStationaryModeParams(mode)
        command.SetCoordinateSystemType(packets.ES_CS_RHR)

        result = command.StartMeasurement()
        reflectors = command.GetReflectors()
        status = command.GetSystemStatus()
        with pytest.raises(Exception, match="Command 55 failed with status 37"):
            command.GoPosition(1, 0.0, 0.0, 3000.0)
    finally:
        connection.disconnect()

    # The home reflector after Initialize, 0.011 mm of noise at 0.16 m, five of it.
    assert (result.dVal1, result.dVal2, result.dVal3) == pytest.approx((150.0, 0.0, -60.0), abs=0.06)
    assert reflectors.iTotalReflectors == 4
    assert status.lTrackerSerialNumber == 390_001
