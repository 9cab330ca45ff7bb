"""Which database a connection has reached, as the server itself says: one server answers to many names.

What lies on this machine of a database is named after the number that its server was made with, the database
and its schema. The names are kept, and not the server's numbers of them: a database that is made anew from an
older copy under its name is found out by the newest link that was noted here.
"""

import contextlib
import hashlib
import re
from pathlib import Path
from typing import Any, Final

import psycopg

from truepose.storage.connection.folder import data_folder
from truepose.storage.errors import ServerRefusedError

_OLDEST: Final = 130000  # that is still looked after
_ASKED: Final = """
    SELECT current_setting('server_version_num')::int, current_setting('server_version'),
        pg_encoding_to_char(encoding), current_schema()
    FROM pg_database WHERE datname = current_database()
"""
_OF_SERVER: Final = "SELECT system_identifier FROM pg_control_system()"
_OF_DATABASE: Final = "SELECT current_database(), current_schema()"
_READ_ONLY: Final = "SELECT current_setting('transaction_read_only') = 'on'"
_NAMED_BY_ADDRESS: Final = (".seal", ".drafts", ".drawn", ".fleets", ".cell.json")  # by earlier versions


def require_fit(connection: Any, where: str) -> None:
    """Raise ServerRefusedError for a database that cannot keep every record as it is given."""
    number, version, encoding, schema = connection.execute(_ASKED).fetchone()
    if number < _OLDEST:
        raise ServerRefusedError(f"The server of {where} is PostgreSQL {version}; take 13 or a newer one.")
    if encoding != "UTF8":
        raise ServerRefusedError(
            f"The database {where} has the encoding {encoding}, which does not keep every text; make one "
            "with ENCODING 'UTF8' TEMPLATE template0. 'truepose copy' brings records there."
        )
    _require_schema(schema, where)


def require_writable(connection: Any, where: str) -> None:
    """Raise ServerRefusedError where the server takes no writes; every transaction would fail."""
    if connection.execute(_READ_ONLY).fetchone()[0]:
        raise ServerRefusedError(read_only(where, "transaction_read_only = on"))


def read_only(where: str, said: str) -> str:
    """Return what is said of a server that takes no writes."""
    return (
        f"The server of {where} takes no writes ({said}); it is a standby, or somebody has set it so: name "
        "the server that writes, or have that set back."
    )


def server_file(connection: Any, where: str) -> Path:
    """Return what on this machine of the database that was reached is named after; raises StorageError."""
    try:
        (server,) = connection.execute(_OF_SERVER).fetchone()
    except psycopg.errors.InsufficientPrivilege as error:
        raise ServerRefusedError(
            f"The server of {where} does not say which one it is; have its administrator GRANT EXECUTE ON "
            "FUNCTION pg_control_system() to the database's user."
        ) from error
    database, schema = connection.execute(_OF_DATABASE).fetchone()
    _require_schema(schema, where)
    readable = re.sub(r"[^\w.-]+", "_", f"{database}_{schema}", flags=re.ASCII)
    unmistakable = hashlib.sha256("\0".join((str(server), database, schema)).encode()).hexdigest()
    return data_folder() / "postgresql" / f"{readable[:60]}_{unmistakable[:12]}"


def _require_schema(schema: str | None, where: str) -> None:
    if schema is None:
        raise ServerRefusedError(
            f"The database {where} has none of the schemas in its search_path; create one, or name another."
        )


def take_over_named(named: Path, file: Path) -> None:
    """Take over what an earlier version has named after the address, where nothing lies here yet."""
    for ending in _NAMED_BY_ADDRESS:
        before, now = (one.with_name(f"{one.name}{ending}") for one in (named, file))
        if before.exists() and not now.exists():
            with contextlib.suppress(OSError):  # then it stays where it is
                before.rename(now)
