"""From a database URL to what it names: a file of SQLite, or a database of a PostgreSQL server."""

import re
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from sqlalchemy import URL, make_url
from sqlalchemy.exc import ArgumentError

from truepose.storage.engine.files import data_folder
from truepose.storage.errors import DatabaseAddressError

_WRITE: Final = "write sqlite:///folder/file.sqlite3 or postgresql://user@host/database."
_IN_MEMORY: Final = {None, "", ":memory:"}
_ALSO: Final = {"postgres": "postgresql", "postgresql+psycopg": "postgresql"}  # as other programs write it


def database_file(url: str) -> Path:
    """Return the SQLite file that `url` names, or what the log of a server's database is named after.

    No database in memory: what was acknowledged has to be on a disk. `reading.lies_beside` says what else
    belongs to a server's database. Raises DatabaseAddressError.
    """
    parsed = parsed_url(url)
    if is_server(parsed):
        # Only the log is named so: it begins before there is a connection that could say which database was
        # reached, and tells why there is none (decision 0068).
        return data_folder() / "postgresql" / re.sub(r"[^\w.-]+", "_", _place(parsed)).strip("_")
    # Resolved once: what lies beside the database must not depend on where the process changes to.
    return Path(str(parsed.database)).expanduser().resolve()


def parsed_url(url: str) -> URL:
    """Return the parts of a URL; raises DatabaseAddressError for what names no database of ours."""
    try:
        parsed = make_url(url)
    # Never quoted as it is: whatever cannot be read as a URL may still hold a password (commit fd77eb26).
    except (ArgumentError, ValueError) as error:  # the latter: its port is no number
        raise DatabaseAddressError(f"{_said(url)} is not a database URL; {_WRITE}") from error
    parsed = parsed.set(drivername=_ALSO.get(parsed.drivername, parsed.drivername))
    known = parsed.get_backend_name() in {"sqlite", "postgresql"} and "+" not in parsed.drivername
    if not known or parsed.database in _IN_MEMORY:
        raise DatabaseAddressError(f"'{display_url(parsed)}' cannot hold records; {_WRITE}")
    return _by_socket(parsed)


def _by_socket(parsed: URL) -> URL:
    """Return a URL whose host is the folder of a socket (`%2Frun%2Fpostgresql`) as one that says so."""
    folder = unquote(parsed.host or "")
    # Other programs write a socket's folder in the place of the host, the library wants it as an option.
    if not folder.startswith("/"):
        return parsed
    by_whom = (parsed.drivername, parsed.username, parsed.password)
    return URL.create(*by_whom, None, parsed.port, parsed.database, {**parsed.query, "host": folder})


def is_server(parsed: URL) -> bool:
    """Whether a URL names a database of a server."""
    return parsed.get_backend_name() == "postgresql"


def display_url(parsed: URL) -> str:
    """Return a URL as people are told of it: without password and options."""
    # Host and port may stand in the options; every other option stays unsaid, `password` among them.
    kept = {name: value for name, value in parsed.query.items() if name in {"host", "port"}}
    return URL.create(
        parsed.drivername, parsed.username, None, parsed.host, parsed.port, parsed.database, kept
    ).render_as_string()


def display_address(url: str) -> str:
    """Return what people are told of a database: its file, or a URL without password and options."""
    parsed = parsed_url(url)
    return display_url(parsed) if is_server(parsed) else str(database_file(url))


def _said(url: str) -> str:
    """Return what may be said of a text that is no URL: none of it where a password may stand in it."""
    return "What was given" if "@" in url or "?" in url else f"'{url}'"


def _place(parsed: URL) -> str:
    host, port, options = (parsed.query.get(name) for name in ("host", "port", "options"))
    place = f"{parsed.host or host or 'local'}_{parsed.port or port or 5432}_{parsed.database}"
    return f"{place}_{options}" if options else place  # a search_path leads to another database's records
