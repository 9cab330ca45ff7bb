"""One server that all tests of a run share, and servers of a test's own."""

import contextlib
import fcntl
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import psycopg

from tests.helpers.postgresql.keeper import as_owner
from truepose.storage.database import Database

TEMPLATE = "empty"
UNSAFE = ("fsync=off", "full_page_writes=off", "max_connections=200")
ODD = (  # what administrators set for others: no record may depend on it
    "datestyle=SQL, DMY",
    "timezone=Asia/Kathmandu",
    "extra_float_digits=-15",
    "bytea_output=escape",
    "quote_all_identifiers=on",
    "transform_null_equals=on",
    "default_transaction_isolation=serializable",
)
# Numbers in texts by their value, upper case before lower: nothing is sorted by it where nobody says so.
COLLATION = "LOCALE_PROVIDER icu ICU_LOCALE 'da-u-kn-true-kf-upper'"
_PLACES = Path("/usr/lib/postgresql")
_KEEPER = Path(__file__).with_name("keeper.py")
_START_S = 120.0


def programs():
    """Return the folder of the newest server that is installed; None where none is."""
    found = [place for place in _PLACES.glob("*/bin") if (place / "initdb").exists()]
    return max(found, key=lambda place: int(place.parent.name), default=None)


@dataclass(frozen=True)
class Server:
    """A running server, reached by the socket in its folder."""

    folder: Path
    options: str = ""  # of URLs

    def url(self, database):
        return f"postgresql://postgres@/{database}?host={self.folder}{self.options}"

    def connect(self, database="postgres"):
        return psycopg.connect(f"host={self.folder} user=postgres dbname={database}", autocommit=True)

    def make(self, name, template=TEMPLATE):
        with self.connect() as connection:
            connection.execute(f'CREATE DATABASE "{name}" TEMPLATE {template} STRATEGY file_copy')
        return self.url(name)

    def drop(self, name):
        with self.connect() as connection:
            connection.execute(f'DROP DATABASE IF EXISTS "{name}" WITH (FORCE)')

    def crash(self):
        """Have the server end as if it were killed, and start it again."""
        self._control("-m", "immediate", "restart")

    def stop(self):
        """Have the server end as an administrator does, whoever is connected."""
        self._control("-m", "fast", "stop")

    def restart(self):
        """Start the server, as it was started before."""
        self._control("restart")

    def _control(self, *words):
        control = [programs() / "pg_ctl", "-D", self.folder / "data", "-w", *words]
        with (self.folder / "log").open("ab") as log:
            command = as_owner([str(part) for part in control], self.folder)
            subprocess.run(
                command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, cwd=self.folder, check=True
            )


@contextlib.contextmanager
def shared_server():
    """Yield the server of this run of tests, which whoever comes first starts and whoever goes last ends."""
    folder = Path(tempfile.gettempdir(), f"truepose-{os.environ.get('PYTEST_XDIST_TESTRUNUID', os.getpid())}")
    with Path(f"{folder}.lock").open("w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        first = not (folder / "ready").exists()
        if first:
            _start(folder, (*UNSAFE, *ODD))
        using = os.open(folder / "users", os.O_WRONLY)
        server = Server(folder, "&fsync=off")
        if first:
            _make_template(server)
    try:
        yield server
    finally:
        os.close(using)
        Path(f"{folder}.lock").unlink(missing_ok=True)


@contextlib.contextmanager
def own_server(*options):
    """Yield a server that keeps what it acknowledges, for one test."""
    folder = Path(tempfile.mkdtemp(prefix="truepose-"))
    _start(folder, options)
    using = os.open(folder / "users", os.O_WRONLY)
    try:
        yield Server(folder)
    finally:
        os.close(using)


def _start(folder, options):
    folder.mkdir(exist_ok=True)
    folder.chmod(0o755)
    os.mkfifo(folder / "users")
    # It outlives whoever starts it, as long as others use it.
    os.spawnv(os.P_NOWAIT, sys.executable, [sys.executable, _KEEPER, folder, programs(), *options])
    until_s = time.monotonic() + _START_S
    while not (folder / "ready").exists():
        if time.monotonic() > until_s:
            raise TimeoutError(f"no server came up in {folder}")
        time.sleep(0.05)


def _make_template(server):
    with server.connect() as connection:
        connection.execute(f"CREATE DATABASE {TEMPLATE} TEMPLATE template0 ENCODING 'UTF8' {COLLATION}")
    before = os.environ.get("XDG_DATA_HOME")
    os.environ["XDG_DATA_HOME"] = str(server.folder / "beside")
    try:
        Database(server.url(TEMPLATE)).close()
    finally:
        if before is None:
            del os.environ["XDG_DATA_HOME"]
        else:
            os.environ["XDG_DATA_HOME"] = before
