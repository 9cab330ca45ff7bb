"""The example bridge runs as its documentation says, and our driver understands it."""

import asyncio
import sys
from pathlib import Path

from tests.helpers.machine import HANGS_S
from truepose_drivers.ballbar_bridge.driver import PLUGIN
from truepose_drivers.monotonic_clock import MonotonicClock

BRIDGE = Path(__file__).parents[3] / "docs" / "examples" / "ballbar_bridge.py"


EXPECTED = {("good", 0.5), ("good", -0.25), ("out_of_range", -1.05), ("none", None)}


def shown(reading):
    return reading.signal, None if reading.signal == "none" else reading.deviation_mm


async def test_numbers_on_standard_input_become_readings():
    bridge = await asyncio.create_subprocess_exec(
        sys.executable, str(BRIDGE), "--port", "0", "--serial", "12A345",
        stdin=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
    )  # fmt: skip
    port = int((await bridge.stderr.readline()).split()[-1])
    driver = PLUGIN.open({"host": "127.0.0.1", "port": port}, MonotonicClock())
    words = asyncio.create_task(say(bridge.stdin, ["0.5", "nonsense", "nan", "-0.25", "low", "none"]))
    try:
        async with asyncio.timeout(HANGS_S):
            await driver.connect()
            identity = await driver.identify()
            seen = set()
            while not seen >= EXPECTED:  # which one follows a question depends on when it was asked
                seen.add(shown(await driver.read()))
    finally:
        words.cancel()
        await driver.close()
        bridge.stdin.close()
        refused = await bridge.stderr.read()
        await bridge.wait()

    assert identity.serial == "12A345"
    assert seen == EXPECTED
    assert b"not passed on: could not convert" in refused
    assert bridge.returncode == 0


async def say(stdin: asyncio.StreamWriter, words: list[str]) -> None:
    while True:
        for word in words:
            stdin.write(word.encode() + b"\n")
            await stdin.drain()
            await asyncio.sleep(0.02)
