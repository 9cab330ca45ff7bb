"""The example bridge to a tracker runs as its documentation says, and our driver understands it."""

import asyncio
import importlib.util
import json
import math
import socketserver
import sys
import threading
from pathlib import Path

import pytest

from tests.helpers.machine import HANGS_S
from truepose_drivers.errors import DeviceRefusedError, ReflectorNotFoundError
from truepose_drivers.guard import guarded
from truepose_drivers.json_bridge.driver import PLUGIN
from truepose_drivers.monotonic_clock import MonotonicClock

BRIDGE = Path(__file__).parents[3] / "docs" / "examples" / "instrument_bridge.py"
REFLECTOR_MM = (2000.0, 300.0, -150.0)


@pytest.fixture
def example():
    """The example as a module, to be filled in."""
    spec = importlib.util.spec_from_file_location("instrument_bridge", BRIDGE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


async def test_as_it_stands_it_is_a_tracker_of_points():
    bridge = await asyncio.create_subprocess_exec(
        sys.executable, str(BRIDGE), "--port", "0", stderr=asyncio.subprocess.PIPE
    )
    port = int((await bridge.stderr.readline()).split()[-1])
    tracker = guarded(
        "json_bridge", "tracker", PLUGIN.open({"host": "127.0.0.1", "port": port}, MonotonicClock())
    )
    try:
        async with asyncio.timeout(HANGS_S):
            await tracker.connect()
            identity = await tracker.identify()
            await tracker.initialise()
            await tracker.find_reflector(REFLECTOR_MM, search_radius_mm=10.0)
            readings = [await tracker.measure_point(duration_s=0.01) for _ in range(2)]
            with pytest.raises(ReflectorNotFoundError, match="in its nest"):
                await tracker.find_reflector((500.0, 0.0, 0.0), search_radius_mm=10.0)
            with pytest.raises(DeviceRefusedError, match="offers no environment"):
                await tracker.environment()
    finally:
        await tracker.close()
        bridge.terminate()
        await bridge.wait()

    assert (identity.manufacturer, identity.model, identity.serial) == ("FARO", "Vantage", "12345")
    assert "SMR of 1.5 in" in tracker.settings
    assert all(math.dist(reading.point_mm, REFLECTOR_MM) < 0.2 for reading in readings)  # 0.01 mm of noise
    assert readings[0].samples == 100


async def test_an_instrument_that_takes_its_time_is_said_to_be_at_work(example):
    go_on = threading.Event()

    class Slow(example.Instrument):
        def initialise(self):
            go_on.wait(60.0)
            return {"settings": "It is warm."}

    example.Bridge.instrument = Slow()
    server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), example.Bridge)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        reader, writer = await asyncio.open_connection(*server.server_address)
        async with asyncio.timeout(HANGS_S):
            writer.write(b'{"id": 4, "ask": "initialise"}\n')
            busy = [json.loads(await reader.readline()) for _ in range(2)]
            go_on.set()
            while (answer := json.loads(await reader.readline())) == busy[0]:
                pass
        writer.close()
        await writer.wait_closed()
    finally:
        server.shutdown()
        server.server_close()

    assert busy == [{"id": 4, "busy": True}] * 2
    assert (answer["id"], answer["serial"], answer["settings"]) == (4, "12345", "It is warm.")
