"""What the service asks of a server: which database was reached, its lock, and whether its commits last.

What lies on this machine of a database is named after the number that its server was made with, the database
and its schema. The names are kept, and not the server's numbers of them: a database that is made anew from an
older copy under its name is found out by the newest link that was noted here.

The connection that writes holds the lock itself: as long as that connection lives nobody else has the lock,
and with the connection goes the lock. So no commit is ever acknowledged by a service that has lost it. And
who gets the lock back after a connection ended knows that the server has done with the one before, and with
its last transaction.
"""

import hashlib
import re
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import psycopg

from truepose.storage.engine.files import data_folder
from truepose.storage.errors import DatabaseInUseError, ServerRefusedError

_OLDEST: Final = 130000  # that is still looked after
_FITNESS: Final = """
    SELECT current_setting('server_version_num')::int, current_setting('server_version'),
        pg_encoding_to_char(encoding), current_schema()
    FROM pg_database WHERE datname = current_database()
"""
_OF_SERVER: Final = "SELECT system_identifier FROM pg_control_system()"
_OF_DATABASE: Final = "SELECT current_database(), current_schema()"
_READ_ONLY: Final = "SELECT current_setting('transaction_read_only') = 'on'"


def require_fit(connection: Any, where: str) -> None:
    """Raise ServerRefusedError for a database that cannot keep every record as it is given."""
    number, version, encoding, schema = connection.execute(_FITNESS).fetchone()
    if number < _OLDEST:
        raise ServerRefusedError(f"The server of {where} is PostgreSQL {version}; use 13 or newer.")
    if encoding != "UTF8":
        raise ServerRefusedError(
            f"The database {where} has the encoding {encoding}, which cannot store every text; create one "
            "with ENCODING 'UTF8' TEMPLATE template0. 'truepose copy' copies records there."
        )
    _require_schema(schema, where)


def require_writable(connection: Any, where: str) -> None:
    """Raise ServerRefusedError where the server takes no writes; every transaction would fail."""
    if connection.execute(_READ_ONLY).fetchone()[0]:
        raise ServerRefusedError(read_only(where, "transaction_read_only = on"))


def read_only(where: str, said: str) -> str:
    """Return what is said of a server that takes no writes."""
    return (
        f"The server of {where} is read-only ({said}); it is a standby, or was set to read-only: use the"
        " primary server, or have the setting changed back."
    )


def server_file(connection: Any, where: str) -> Path:
    """Return what on this machine of the database that was reached is named after; raises StorageError."""
    try:
        (server,) = connection.execute(_OF_SERVER).fetchone()
    except psycopg.errors.InsufficientPrivilege as error:
        raise ServerRefusedError(
            f"The server of {where} does not identify itself; ask its administrator to GRANT EXECUTE ON "
            "FUNCTION pg_control_system() to the database's user."
        ) from error
    database, schema = connection.execute(_OF_DATABASE).fetchone()
    _require_schema(schema, where)
    readable = re.sub(r"[^\w.-]+", "_", f"{database}_{schema}", flags=re.ASCII)
    # The readable part is cut and cleaned, so that two databases may agree in it; the digest tells them
    # apart.
    unmistakable = hashlib.sha256("\0".join((str(server), database, schema)).encode()).hexdigest()
    return data_folder() / "postgresql" / f"{readable[:60]}_{unmistakable[:12]}"


def _require_schema(schema: str | None, where: str) -> None:
    if schema is None:
        raise ServerRefusedError(
            f"The database {where} has none of the schemas in its search_path; create one, or choose"
            " another database."
        )


# "tpse" in ASCII.
_OURS: Final = 0x74_70_73_65  # among the locks that other programs take in the same database
_TRY: Final = "SELECT pg_try_advisory_lock(?, hashtext(current_schema()))"
_PATIENCE_S: Final = 2.0  # until the server has noticed that a service was killed
_AGAIN_S: Final = 0.05


def take_lock(connection: Any, where: str, patience_s: float = _PATIENCE_S) -> None:
    """Take the lock for as long as a plain connection lives; raises DatabaseInUseError."""
    until_s = time.monotonic() + patience_s
    while not connection.execute(_TRY, (_OURS,)).fetchone()[0]:
        if time.monotonic() > until_s:
            raise DatabaseInUseError(
                f"The database {where} is in use by another truepose service; "
                "stop that one, or choose another database with --database."
            )
        time.sleep(_AGAIN_S)


_SETTINGS: Final = (
    "SELECT name, setting FROM pg_settings WHERE name IN ('fsync', 'full_page_writes', 'data_checksums')"
)

# What is acknowledged can go with the power; only where the file system tears pages; wrong bits show later.
_BY_WEIGHT: Final = ("fsync", "full_page_writes", "data_checksums")


def settings_of(connection: Any) -> dict[str, str]:
    """Return how a server keeps what it acknowledges."""
    return dict(connection.execute(_SETTINGS).fetchall())


def require_durable(where: str, settings: Mapping[str, str], *, accepted: bool) -> None:
    """Raise ServerRefusedError for a server that loses acknowledged records, unless that is accepted."""
    if settings.get("fsync") == "off" and not accepted:
        raise ServerRefusedError(
            f"The server of {where} runs with fsync = off: a power failure can lose acknowledged records."
            " Set fsync = on there; for tests only, add ?fsync=off to the URL."
        )


def doubts(settings: Mapping[str, str]) -> tuple[str, ...]:
    """Return the settings that are off, the gravest first."""
    return tuple(name for name in _BY_WEIGHT if settings.get(name) == "off")
