"""Files that nobody reads but their owner, whatever the umask: they hold what opens the service.

Windows knows no such modes: there a file has the rights of its folder.
"""

import contextlib
import os
import stat
from pathlib import Path
from typing import Final

_MODE: Final = 0o600
_OTHERS: Final = 0o077


def opened_alone(file: str | Path, flags: int) -> int:
    """Open a file that its owner alone reads, also one that others could read before; for `open`'s opener."""
    descriptor = os.open(file, flags, _MODE)
    if os.name == "posix":
        with contextlib.suppress(OSError):  # somebody else's file, which may be used all the same
            os.fchmod(descriptor, _MODE)
    return descriptor


def make_alone(file: Path) -> None:
    """Make an empty file that its owner alone reads; one that is there becomes so.

    What is there is not opened: closing it again would drop the locks that SQLite has on it.
    """
    with contextlib.suppress(FileExistsError):
        os.close(opened_alone(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
    tighten(file)


def tighten(*files: Path) -> None:
    """Take from everybody but the owner what they may do with files that are there."""
    for file in files if os.name == "posix" else ():
        with contextlib.suppress(OSError):
            mode = stat.S_IMODE(file.stat().st_mode)
            if mode & _OTHERS:
                file.chmod(mode & ~_OTHERS)
