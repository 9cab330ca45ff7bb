"""The SQLite library that the storage uses, and whether it has the fault of the WAL reset.

SQLite 3.7.0 to 3.51.2 may corrupt a database in WAL mode where one connection resets the log while another
one makes a checkpoint (sqlite.org, "The WAL-reset bug"; mended in 3.51.3, 3.50.7 and 3.44.6). Python's own
module has whatever library the system ships, so a newer one is taken where it is installed. With an older
one the fault cannot strike either: in this process only the writer's thread writes and makes checkpoints,
and the lock keeps other services off.
"""

import importlib
import sqlite3
from types import ModuleType
from typing import Final

_MENDED: Final = (3, 51, 3)
_MENDED_LINES: Final = {(3, 50): 7, (3, 44): 6}  # older lines and their first patch with the mend
_FIRST_FAULTY: Final = (3, 7, 0)


def has_wal_reset_fault(version: tuple[int, int, int]) -> bool:
    """Whether a version of SQLite may corrupt a database when it resets the write-ahead log."""
    if version < _FIRST_FAULTY or version >= _MENDED:
        return False
    mended_from = _MENDED_LINES.get(version[:2])
    return mended_from is None or version[2] < mended_from


def _newest() -> ModuleType:
    """Return the module with the newer library: the one that is installed beside Python's, or Python's."""
    try:
        beside = importlib.import_module("pysqlite3.dbapi2")
    except ImportError:
        return sqlite3
    return beside if beside.sqlite_version_info > sqlite3.sqlite_version_info else sqlite3


LIBRARY: Final = _newest()
VERSION: Final[str] = LIBRARY.sqlite_version
FAULTY: Final = has_wal_reset_fault(LIBRARY.sqlite_version_info)
