"""An independent emScon client, unchanged, against the simulated tracker."""

import asyncio
import importlib
import threading
from dataclasses import replace

import pytest

from tests.helpers.machine import CESAPI
from truepose_simulators.cell.clock import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.tracker.leica_emscon import tracker_endpoint
from truepose_simulators.scenarios.file import load_scenario


@pytest.fixture
def port():
    """Port of a tracker served from another thread; that client blocks."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    cell = Cell(replace(load_scenario("irb120-tilted")), 1, CellClock(0))
    endpoint = tracker_endpoint(cell)
    address = asyncio.run_coroutine_threadsafe(endpoint.open("127.0.0.1", 0), loop).result()
    yield address.port
    asyncio.run_coroutine_threadsafe(endpoint.close(), loop).result()
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


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
