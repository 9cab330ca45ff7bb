"""How a process of this program is asked to end, and how it ends those that it started, on every system."""

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

# Ctrl-C; a service manager; on Windows alone Ctrl-Break, which a closed window is told by as well.
_ASKING = ("SIGINT", "SIGTERM", "SIGBREAK")


@contextlib.contextmanager
def asked_to_end(end: Callable[[], None]) -> Iterator[None]:
    """Have the running loop call `end` whenever somebody asks this process to end."""
    loop = asyncio.get_running_loop()
    with contextlib.ExitStack() as held:
        for number in (getattr(signal, name) for name in _ASKING if hasattr(signal, name)):
            try:
                loop.add_signal_handler(number, end)
                held.callback(loop.remove_signal_handler, number)
            except NotImplementedError:  # Windows: there the signal itself wakes the loop
                before = signal.signal(number, lambda *_: loop.call_soon_threadsafe(end))
                held.callback(signal.signal, number, before)
        yield


def interrupt_this_process() -> None:
    """Ask this process to end, from any of its threads."""
    if sys.platform == "win32":  # where `os.kill` ends a process on the spot
        signal.raise_signal(signal.SIGINT)
    else:
        os.kill(os.getpid(), signal.SIGINT)


def in_own_group() -> dict[str, Any]:
    """Return the arguments that start a process which Ctrl-C at the terminal does not reach."""
    flag = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", None)
    return {"start_new_session": True} if flag is None else {"creationflags": flag}


def kill_group(process: asyncio.subprocess.Process) -> None:
    """Kill a process that was started in its own group, with all that is left of the group.

    Windows has no such groups: there what it started ends by itself, as its input closes.
    """
    with contextlib.suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
