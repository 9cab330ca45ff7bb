"""Ports for programs that are told one, started after it was found free, or started again at it."""

import contextlib
import random
import socket

# Below those that the system gives to whoever asks for any: tests beside this one do so all the time.
_PORTS = range(20_000, 30_000)


def free_block(count: int) -> int:
    """Return the first of so many free consecutive ports."""
    for _ in range(50):
        first = random.choice(_PORTS)  # not for secrets
        with contextlib.suppress(OSError), contextlib.ExitStack() as stack:
            for offset in range(count):
                stack.enter_context(socket.create_server(("127.0.0.1", first + offset)))
            return first
    raise AssertionError("this machine has no free ports in a row")


def free_port() -> int:
    """Return a port at which nobody listens."""
    return free_block(1)
