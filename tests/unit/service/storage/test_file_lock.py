"""One lock on a database file, by the calls of each system."""

import ctypes
import os
import sqlite3
import sys
from types import ModuleType

import pytest

from truepose.storage.backup.copying import back_up
from truepose.storage.backup.restoring import restore
from truepose.storage.database import Database
from truepose.storage.engine import sqlite_file as service_lock
from truepose.storage.engine.sqlite_file import ServiceLock, file_lock, locked_file
from truepose.storage.errors import DatabaseInUseError
from truepose.storage.integrity.database_identity import IdentityFile
from truepose.storage.integrity.verification import verify_left


class Windows:
    """What is asked of Windows: byte ranges of handles, each to be had by one handle at a time."""

    def __init__(self):
        self.locked = {}  # handle by file and position
        self.error = 0

    def handle_of(self, file):
        return 0x700000000 + file

    def LockFile(self, handle, low, high, length_low, length_high):  # noqa: N802 (Windows calls it so)
        file = os.fstat(handle.value - 0x700000000)
        place = (file.st_ino, high << 32 | low)
        if place not in self.locked:
            self.locked[place] = handle.value
            return 1
        self.error = 33
        return 0


@pytest.fixture
def windows(monkeypatch):
    """Calls of Windows in the place of this system's."""
    system, module = Windows(), ModuleType("msvcrt")
    module.get_osfhandle = system.handle_of
    monkeypatch.setitem(sys.modules, "msvcrt", module)
    monkeypatch.setattr(ctypes, "WinDLL", lambda name, use_last_error: system, raising=False)
    monkeypatch.setattr(ctypes, "get_last_error", lambda: system.error, raising=False)
    monkeypatch.setattr(service_lock, "file_lock", lambda: file_lock("win32"))
    monkeypatch.setitem(sys.modules, "fcntl", None)
    return system


@pytest.fixture(params=["linux", "win32"])
def system(request):
    if request.param == "win32":
        request.getfixturevalue("windows")
    elif sys.platform != "linux":
        pytest.skip("there is no flock to try")


def test_one_of_two_who_reach_a_file_by_two_names_has_it(system, tmp_path):
    database, other_name = tmp_path / "cell.sqlite3", tmp_path / "other.sqlite3"
    held = locked_file(database)
    other_name.hardlink_to(database)

    with pytest.raises(DatabaseInUseError, match="is in use by another truepose service"):
        locked_file(other_name)

    os.close(held)


def test_what_is_locked_on_windows_is_a_byte_that_no_database_reaches(windows, tmp_path):
    file = locked_file(tmp_path / "cell.sqlite3")

    ((_, position),) = windows.locked
    assert position == 1 << 62
    os.close(file)


def test_a_lock_that_windows_refuses_for_another_reason_is_no_other_service(windows, tmp_path):
    windows.LockFile = lambda *_: 0
    windows.error = 50
    with (tmp_path / "file").open("wb") as file, pytest.raises(PermissionError, match="error 50"):
        file_lock("win32")(file.fileno())


def test_a_system_without_such_a_lock_has_the_side_file_alone(monkeypatch, tmp_path):
    monkeypatch.setattr(service_lock, "file_lock", lambda: file_lock("darwin"))
    lock = ServiceLock(tmp_path / "cell.sqlite3")

    with pytest.raises(DatabaseInUseError):
        ServiceLock(tmp_path / "cell.sqlite3")

    lock.release()


def test_a_copy_is_restored_to_a_new_place_also_without_such_a_lock(monkeypatch, tmp_path):
    database, copy = tmp_path / "cell.sqlite3", tmp_path / "copy.sqlite3"
    Database(f"sqlite:///{database}").close()
    back_up(database, copy)
    monkeypatch.setattr(service_lock, "file_lock", lambda: file_lock("darwin"))

    head, kept = restore(copy, tmp_path / "fresh.sqlite3")

    assert (verify_left(tmp_path / "fresh.sqlite3").head, kept) == (head, None)


@pytest.mark.skipif(sys.platform != "linux", reason="open files are looked for in /proc")
def test_nothing_holds_a_database_open_that_is_replaced(monkeypatch, tmp_path):
    database, copy = tmp_path / "cell.sqlite3", tmp_path / "copy.sqlite3"
    Database(f"sqlite:///{database}").close()
    back_up(database, copy)
    open_while_replaced = []
    replaced = os.replace

    def replacing(source, target, **options):
        if os.fspath(target) == os.fspath(database):
            open_while_replaced.extend(
                name for name in os.listdir("/proc/self/fd") if _leads_to(name, database)
            )
        replaced(source, target, **options)

    monkeypatch.setattr(os, "replace", replacing)

    restore(copy, database, replace=True)

    assert open_while_replaced == []
    assert database.exists()


def test_lines_beside_a_database_are_written_as_they_are(monkeypatch, tmp_path):
    flags = []
    opened = os.open
    monkeypatch.setattr(os, "O_BINARY", 0x8000, raising=False)  # no such flag here
    monkeypatch.setattr(
        os, "open", lambda file, how, *of, **more: flags.append(how) or opened(file, how, *of, **more)
    )
    monkeypatch.delattr(os, "O_CLOEXEC", raising=False)
    database = sqlite3.connect(tmp_path / "cell.sqlite3")
    database.execute("CREATE TABLE links (id INTEGER, hash BLOB)")

    IdentityFile(tmp_path / "cell.sqlite3").break_open(database)

    assert flags[0] & 0x8000
    database.close()


def _leads_to(descriptor, file):
    try:
        return os.path.samefile(f"/proc/self/fd/{descriptor}", file)
    except OSError:
        return False
