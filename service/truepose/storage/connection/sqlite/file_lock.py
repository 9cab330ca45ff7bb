"""The system's own lock on an open file, which it releases with the process, however that ends.

SQLite's locks are of another kind and never meet it. macOS has none that does not get in their way.
"""

import ctypes
import errno
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final

_TAKEN: Final = 33  # ERROR_LOCK_VIOLATION
_FAR: Final = 1 << 30  # upper half of a position: nobody may read a locked byte, and no file goes so far


def file_lock(system: str = sys.platform) -> Callable[[int], None] | None:
    """Return what locks an open file; None where the system has no such lock.

    It raises BlockingIOError where somebody else has the lock, OSError where the file system refuses.
    """
    return {"linux": _flock, "win32": _lock_far_byte}.get(system)


def _flock(file: int) -> None:
    import fcntl

    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _lock_far_byte(file: int) -> None:
    windows: Any = ctypes
    kernel = windows.WinDLL("kernel32", use_last_error=True)
    handle = import_module("msvcrt").get_osfhandle(file)
    # Not msvcrt.locking: its positions end at 2 GB, within what a database may hold.
    if not kernel.LockFile(ctypes.c_void_p(handle), 0, _FAR, 1, 0):
        code = windows.get_last_error()
        kind = BlockingIOError if code == _TAKEN else OSError
        raise kind(errno.EACCES, f"Windows does not lock it, error {code}")
