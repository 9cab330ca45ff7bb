"""The folder of the user's own data, and files that nobody reads but their owner, whatever the umask.

Windows knows no such modes: there a file has the rights of its folder.
"""

import contextlib
import os
import stat
import sys
from pathlib import Path
from typing import Final


def data_folder() -> Path:
    """Return the folder of the user's own data, where the platform keeps such things.

    Not the working directory: measurements must not depend on where somebody happened to stand.
    """
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "truepose"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "truepose"
    # `or`: the variable may be set and empty, which the XDG specification takes for unset.
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "truepose"


_MODE: Final = 0o600
_OTHERS: Final = 0o077


def opened_alone(file: str | Path, flags: int) -> int:
    """Open a file that its owner alone reads, also one that others could read before; for `open`'s opener."""
    # The mode at creation counts from the first moment; changing it afterwards would leave one in which
    # others can open the file. As it is: Windows would read and write line ends of two bytes.
    descriptor = os.open(file, flags | getattr(os, "O_BINARY", 0), _MODE)
    if os.name == "posix":
        with contextlib.suppress(OSError):  # somebody else's file, which may be used all the same
            # Also a file that was there before has the mode: the umask, or an earlier version, may have left
            # it open to everybody.
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
    # Only rights are taken away: whoever made a file read-only for its owner meant something by it.
    for file in files if os.name == "posix" else ():
        with contextlib.suppress(OSError):
            mode = stat.S_IMODE(file.stat().st_mode)
            if mode & _OTHERS:
                file.chmod(mode & ~_OTHERS)


def write_whole(file: Path, data: bytes) -> None:
    """Write a file that its owner alone reads: whole and on the disk, or not at all. Raises OSError."""
    os.replace(_part_of(file, data), file)
    sync_folder(file.parent)


def write_new(file: Path, data: bytes) -> None:
    """Do the same where nothing lies yet; raises FileExistsError, OSError."""
    put_new(_part_of(file, data), file)


def put_new(part: Path, file: Path) -> None:
    """Give a file on the disk its name, unless something has it; raises FileExistsError, OSError."""
    # Renaming would replace what somebody has put there meanwhile; a second name is only given where there is
    # none.
    os.link(part, file)
    part.unlink()
    sync_folder(file.parent)


def _part_of(file: Path, data: bytes) -> Path:
    part = file.with_name(f"{file.name}.part")
    with open(part, "wb", opener=opened_alone) as written:
        written.write(data)
        written.flush()
        os.fsync(written.fileno())
    return part


def sync_file(file: Path) -> None:
    """Bring a file to the disk that something else has written."""
    with file.open("rb+") as written:
        os.fsync(written.fileno())


def sync_folder(folder: Path) -> None:
    """See that a name that was just given or taken in a folder is on the disk."""
    # Windows does not open folders as files.
    if os.name == "posix":
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)
