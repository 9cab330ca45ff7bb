"""A connection whose line goes dead, for a process with a network of its own.

Prints the seconds until each of two drivers is told: one that only listens, and one that sends meanwhile.
"""

import asyncio
import contextlib
import subprocess
import sys
import time

from truepose_drivers.errors import LinkError
from truepose_drivers.transports.tcp import TcpLink

_GIVE_UP_S = 20.0


async def listen(reader, writer):
    with contextlib.suppress(OSError, asyncio.CancelledError):
        while await reader.read(100):
            pass


def line(state):
    subprocess.run(["ip", "link", "set", "lo", state], check=True)


async def told_after_s(link, *, sends):
    """Return how long it takes until a driver is told that its line is dead [s]."""
    began_s = time.monotonic()
    with contextlib.suppress(LinkError):
        while time.monotonic() - began_s < _GIVE_UP_S:
            if sends:
                await link.send(b"beat")
            await link.receive(0.2)
    return time.monotonic() - began_s


async def main():
    line("up")
    server = await asyncio.start_server(listen, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    listens, speaks = TcpLink("127.0.0.1", port), TcpLink("127.0.0.1", port)
    for link in (listens, speaks):
        await link.open()
        await link.send(b"are you there?")
    line("down")
    told = await asyncio.gather(told_after_s(listens, sends=False), told_after_s(speaks, sends=True))
    sys.stdout.writelines(f"{took_s:.2f}\n" for took_s in told)


if __name__ == "__main__":  # imported, it would take down the loopback of the machine
    asyncio.run(main())
