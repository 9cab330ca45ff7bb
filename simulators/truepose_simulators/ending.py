"""How a simulated cell is asked to end, on every system."""

import asyncio
import signal

# Ctrl-C; a service manager; on Windows alone Ctrl-Break, which a closed window is told by as well.
_ASKING = ("SIGINT", "SIGTERM", "SIGBREAK")


def asked_to_end() -> asyncio.Event:
    """Return what is set when somebody asks this process to end, which is the last that its loop does."""
    loop, asked = asyncio.get_running_loop(), asyncio.Event()
    for number in (getattr(signal, name) for name in _ASKING if hasattr(signal, name)):
        try:
            loop.add_signal_handler(number, asked.set)
        except NotImplementedError:  # Windows: there the signal itself wakes the loop
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(asked.set))
    return asked
