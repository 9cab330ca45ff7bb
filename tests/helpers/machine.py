"""What a machine may lack and what a run says of it at its end; where it writes its files."""

import os
import socket
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pytest

# Whatever is waited for so long is lost: beside other suites a machine is ten times slower than alone.
HANGS_S: Final = 300.0


@dataclass(frozen=True, slots=True)
class Lack:
    """Something that a machine may be without."""

    reason: str  # with which a test is skipped
    untested: str


MEASURED_DATA = Lack(
    "TRUEPOSE_DATA does not name the folder of example campaigns", "campaigns that were measured"
)
UMOCKDEV = Lack(
    "umockdev is not installed (Debian: umockdev): no device to open",
    "hidapi on a device that is made up",
)
CHROMIUM = Lack("no Chromium is installed here", "pages in a browser")
CESAPI = Lack("CESAPI 1.1.3 is not installed: no independent client", "a tracker's client by others")
NDICAPI = Lack("ndicapi 3.7.6 is not installed: no independent client", "a camera's client by others")
ABB_ROBOT_CLIENT = Lack(
    "abb-robot-client 0.4.0 is not installed: no independent client", "a robot controller's client by others"
)
OWN_NETWORK = Lack(
    "no process gets a network of its own here (unshare, ip)", "connections whose line goes dead"
)
POSTGRESQL = Lack("no PostgreSQL server is installed (Debian: postgresql)", "records on a PostgreSQL server")
PANGO = Lack("Pango is not installed (Debian: libpango-1.0-0, libpangoft2-1.0-0)", "reports as PDF")
# What other systems than Linux do without.
PSEUDO_TERMINALS = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo terminals here")
NAMED_PIPES = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipe is a file here")
UNIX_SOCKETS = pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="no socket is a file here")
DEVICE_FILES = pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no device is a file here")
POSIX_MODES = pytest.mark.skipif(os.name != "posix", reason="Windows knows no such modes")
TIME_ZONES = pytest.mark.skipif(
    not hasattr(time, "tzset"), reason="no process has a time zone of its own here"
)
KILLING_SIGNALS = pytest.mark.skipif(os.name != "posix", reason="no signal kills a process of Windows")
FOLDERS_IN_MEMORY = pytest.mark.skipif(not hasattr(os, "ST_NOEXEC"), reason="no folder in memory here")
_MEMORY: Final = Path("/dev/shm")
_ROOM_BYTES: Final = 3 * 2**30  # a whole run leaves less than one, were every folder kept
_ALL = (MEASURED_DATA, UMOCKDEV, CHROMIUM, CESAPI, NDICAPI, ABB_ROBOT_CLIENT, OWN_NETWORK, POSTGRESQL, PANGO)


def what_was_untested(reasons: Iterable[str]) -> str:
    """One line about what could not be tested here, empty where nothing was lacking.

    Parameters
    ----------
    reasons : iterable of str
        Why each of the skipped tests was skipped.
    """
    told = list(reasons)
    counted = [(lack, sum(lack.reason in reason for reason in told)) for lack in _ALL]
    parts = [f"{lack.untested} ({lack.reason}; {count} skipped)" for lack, count in counted if count]
    return f"Not tested on this machine: {', '.join(parts)}." if parts else ""


def folder_in_memory(folder: Path = _MEMORY) -> Path | None:
    """Return where files lie in memory; None where that is small or forbids programs, or no such thing is.

    A commit that waits for a disk waits most of its time. What a killed process has written is there
    afterwards, as on a disk; a computer that loses its power is in no test.
    """
    if not hasattr(os, "statvfs"):  # Windows
        return None
    try:
        found = os.statvfs(folder)
    except OSError:
        return None
    roomy = found.f_bavail * found.f_frsize >= _ROOM_BYTES and not found.f_flag & os.ST_NOEXEC
    return folder if roomy and os.access(folder, os.W_OK) else None
