"""How many connections fit into what the operating system lets a process open.

A process that has none left can neither accept a connection nor open its database, a serial port or a worker.
Beyond number 1023 `select` cannot wait for a descriptor, and pyserial waits with it: so all stay below.
"""

import sys
from typing import Final

_SELECTABLE: Final = 1024
_OWN: Final = 256  # database, devices, simulated cell, workers, and connections that are about to be closed
_OWN_SHARE: Final = 4


def connection_limit() -> int:
    """Raise this process's limit as far as is of use, and return how many connections fit into it."""
    files = _SELECTABLE if sys.platform == "win32" else _raised_limit()
    return files - min(_OWN, files // _OWN_SHARE)


if sys.platform != "win32":
    import resource

    def _raised_limit() -> int:
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        most = _SELECTABLE if hard == resource.RLIM_INFINITY else min(_SELECTABLE, hard)
        if soft != resource.RLIM_INFINITY and soft < most:
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
        return most
