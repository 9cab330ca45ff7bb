"""Tells systemd that the service is ready, and that it lives (sd_notify(3)); where there is none, nobody."""

import asyncio
import contextlib
import os
import socket
from typing import Final

_MICROSECONDS: Final = 1e6
_OFTEN: Final = 3.0  # times within the time after which the service counts as hung


def tell(state: str) -> None:
    """Send a state to the service manager that started this process."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address or not hasattr(socket, "AF_UNIX"):
        return
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(state.encode(), f"\0{address[1:]}" if address.startswith("@") else address)


async def keep_telling() -> None:
    """Say that the event loop turns, as often as the service manager wants it; return where it does not."""
    hung_after_s = float(os.environ.get("WATCHDOG_USEC") or 0) / _MICROSECONDS
    while hung_after_s > 0:
        tell("WATCHDOG=1")
        await asyncio.sleep(hung_after_s / _OFTEN)
