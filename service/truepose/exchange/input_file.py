"""Reading a file that a user names: a regular one, of a size that it can have, never one that waits.

A pipe or a terminal gives nothing until somebody writes, a device gives for ever: neither is opened.
"""

import os
import stat
from pathlib import Path
from typing import Final

from truepose.exchange.errors import MissingFileError, UnreadableFileError

# 200,000 rows of a table with everything that the format knows come to 100 MB.
GREATEST_BYTES: Final = 128 * 2**20
_KINDS: Final = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
# Not to wait for the other end of what became a pipe since it was looked at; Windows knows neither.
_AT_ONCE: Final = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)


def read_bytes(path: Path, *, most: int = GREATEST_BYTES) -> bytes:
    """Return the content of a file.

    Parameters
    ----------
    path : Path
        A regular file, or a link to one.
    most : int
        Bytes that are read; a file that has more is refused.

    Raises
    ------
    MissingFileError, UnreadableFileError
        With the name of the file.
    """
    try:
        # Looked at before it is opened: to open some devices already does something.
        _require_regular(path, path.stat())
        with open(path, "rb", opener=_open_at_once) as file:
            _require_regular(path, os.fstat(file.fileno()))
            data = file.read(most + 1)
    except FileNotFoundError as error:
        raise MissingFileError("there is no such file", file=path.name) from error
    except (OSError, ValueError) as error:  # a name with a zero byte is no name
        reason = error.strerror if isinstance(error, OSError) else error
        raise UnreadableFileError(f"the file cannot be read ({reason})", file=path.name) from error
    if len(data) > most:
        raise UnreadableFileError(
            f"the file has more than {most // 2**20} MB, the most that is read", file=path.name
        )
    return data


def _open_at_once(path: str, flags: int) -> int:
    return os.open(path, flags | _AT_ONCE)


def _require_regular(path: Path, found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        kind = next((words for is_kind, words in _KINDS if is_kind(found.st_mode)), "something else")
        raise UnreadableFileError(f"this is {kind}, not a file; name a file", file=path.name or str(path))
