"""Run under umockdev: reads a HID ballbar through the registered driver and prints what it saw as JSON."""

import asyncio
import json
import sys
from dataclasses import asdict

from truepose_drivers.ballbar_hid.driver import PLUGIN
from truepose_drivers.errors import DriverError
from truepose_drivers.monotonic_clock import MonotonicClock


async def main(usb: str, readings: int) -> None:
    driver = PLUGIN.open({"usb": usb}, MonotonicClock())
    seen: dict[str, object] = {}
    try:
        await driver.connect()
        seen["identity"] = asdict(await driver.identify())
        seen["readings"] = []
        for _ in range(readings):
            seen["readings"].append(asdict(await driver.read()))
            await asyncio.sleep(0.2)
    except DriverError as error:
        seen["error"] = [type(error).__name__, str(error)]
    await driver.close()
    sys.stdout.write(json.dumps(seen))


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2])))
