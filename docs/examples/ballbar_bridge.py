"""A ballbar bridge: passes numbers from standard input on to truepose.

    my-vendor-reader | python ballbar_bridge.py --serial 12A345

Each line on standard input is one value of the ballbar as it comes: its deviation [mm], longer than at zero
being positive. `none` says that there is no signal, `low` or `high` that the bar stands at its stop. Put your
own call to the maker's software where `values` reads a line. It needs nothing but Python.
"""

import argparse
import asyncio
import json
import sys
from collections.abc import AsyncIterator

STOP_MM = 1.05  # what we say of a bar that stands at its stop


async def values() -> AsyncIterator[str]:
    """Yield what the ballbar shows, one word a value, until there is no more."""
    while line := await asyncio.to_thread(sys.stdin.readline):
        if line.strip():
            yield line.strip()


def message(word: str, sequence: int) -> dict[str, object]:
    """Return the line for one value; raises ValueError for a word that is none."""
    if word == "none":
        return {"deviation_mm": None, "signal": "none", "sequence": sequence}
    if word in ("low", "high"):
        deviation_mm = STOP_MM if word == "high" else -STOP_MM
        return {"deviation_mm": deviation_mm, "signal": "out_of_range", "sequence": sequence}
    return {"deviation_mm": float(word), "signal": "good", "sequence": sequence}


async def main() -> None:
    """Listen, and pass every value on to whoever is connected."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on")
    parser.add_argument("--port", type=int, default=7420, help="port to listen on; 0: any")
    parser.add_argument("--model", default="QC20-W")
    parser.add_argument("--serial", default="")
    options = parser.parse_args()
    hello = {"model": options.model, "serial": options.serial, "unit": "mm", "resolution_mm": 0.0001}
    listeners: set[asyncio.StreamWriter] = set()

    async def welcome(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(json.dumps(hello).encode() + b"\n")
        listeners.add(writer)

    server = await asyncio.start_server(welcome, options.host, options.port)
    sys.stderr.write(f"listening on port {server.sockets[0].getsockname()[1]}\n")
    sys.stderr.flush()
    sequence = 0
    async for word in values():
        sequence += 1
        try:
            line = json.dumps(message(word, sequence), allow_nan=False).encode() + b"\n"
        except ValueError as error:
            sys.stderr.write(f"not passed on: {error}\n")
            continue
        for writer in {writer for writer in listeners if writer.is_closing()}:
            listeners.discard(writer)
        for writer in listeners:
            writer.write(line)  # never an old value twice: a bar that stopped sending must not look steady


if __name__ == "__main__":
    asyncio.run(main())
