"""Room that is kept for the moment when the disk is full: what is under way then is still brought to its end.

A file beside the database holds 16 MiB, which are given up where a commit finds no room. Some eight thousand
readings fit into them. As long as they are given up nothing new begins; once there is room again, they are
taken back.
"""

import contextlib
import os
import shutil
from pathlib import Path
from typing import Final

from truepose.storage.files.owner_alone import opened_alone

_BYTES: Final = 16 * 2**20
_ELSE_FREE: Final = 32 * 2**20  # of the disk, beside the reserve: others live there too


class Reserve:
    """The file that is given up; taken and given up on the writer's thread."""

    def __init__(self, database: Path) -> None:
        self.file = database.with_name(f"{database.name}.reserve")
        self.used = False  # given up, and not taken back yet

    def take(self) -> None:
        """Take the room where it is not taken; where there is none to spare, nothing happens."""
        if self._is_whole:
            return
        with contextlib.suppress(OSError):
            if shutil.disk_usage(self.file.parent).free < _BYTES + _ELSE_FREE:
                return
            self._allocate()
            self.used = False

    def give_up(self) -> bool:
        """Give the room back to the disk; returns whether there was any."""
        whole = self._is_whole
        self.release()
        self.used = self.used or whole
        return whole

    def release(self) -> None:
        """Give the room back, as nobody needs it any more."""
        with contextlib.suppress(OSError):
            self.file.unlink(missing_ok=True)

    @property
    def _is_whole(self) -> bool:
        with contextlib.suppress(OSError):
            return self.file.stat().st_size == _BYTES
        return False

    def _allocate(self) -> None:
        with open(self.file, "wb", opener=opened_alone) as file:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, _BYTES)
            else:
                file.write(bytes(_BYTES))
