"""Reading a file that a user names: a regular one of a size that it can have, never one that waits."""

import errno
import os
import stat
from pathlib import Path
from typing import Final

_GREATEST_BYTES: Final = 128 * 2**20
# Not to wait for the other end of what became a pipe since it was looked at; Windows has no such thing.
_AT_ONCE: Final = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)


def read_file(path: Path) -> bytes:
    """Return the content of a file; raises OSError, also for a pipe, a device or a folder."""
    # Looked at before it is opened: to open some devices already does something.
    _require_regular(path, path.stat())
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | _AT_ONCE)) as file:
        _require_regular(path, os.fstat(file.fileno()))
        data = file.read(_GREATEST_BYTES + 1)
    if len(data) > _GREATEST_BYTES:
        raise OSError(errno.EFBIG, f"it has more than {_GREATEST_BYTES // 2**20} MB", str(path))
    return data


def read_text(path: Path) -> str:
    """Return the text of a file, with or without a byte order mark; raises OSError, UnicodeDecodeError."""
    return read_file(path).decode("utf-8-sig")


def _require_regular(path: Path, found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is no file but a folder, a pipe or a device", str(path))
