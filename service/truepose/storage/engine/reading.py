"""Connections that read a database from outside, whoever has it open."""

import importlib.util
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from truepose.storage.engine.address import database_file, display_address, display_url, is_server, parsed_url
from truepose.storage.engine.sqlite_connections import LIBRARY, opened_file
from truepose.storage.engine.sqlite_file import ServiceLock
from truepose.storage.errors import DatabaseAddressError


def open_reader(url: str) -> Any:
    """Return a plain connection that reads a database and keeps nobody from writing; raises StorageError."""
    if not is_server(parsed_url(url)):
        return opened_file(database_file(url))
    require_library()
    from truepose.storage.engine.postgresql_connections import REFUSED, open_connection, translate_error

    try:
        return open_connection(url)
    except REFUSED as error:
        raise translate_error(display_url(parsed_url(url)), error) from error


def lies_beside(url: str) -> Path:
    """Return what everything on this machine that belongs to a database is named after.

    That is the file itself, or what the server itself calls the database: whoever reaches it by another name
    finds the same. Raises StorageError.
    """
    if not is_server(parsed_url(url)):
        return database_file(url)
    with closing(open_reader(url)) as connection:
        from truepose.storage.engine.postgresql_server import server_file

        return server_file(connection, display_address(url))


@contextmanager
def locked_for_reading(url: str) -> Iterator[Any]:
    """Keep every service off a database, and yield what reads it; raises StorageError.

    Of a server's database the connection that reads holds the lock: as long as it answers nobody else has it.
    """
    if not is_server(parsed_url(url)):
        # Behind the service's own lock nobody writes, so that what is read stays as it is for as long as that
        # takes.
        lock = ServiceLock(database_file(url))
        try:
            with closing(open_reader(url)) as connection:
                yield connection
        finally:
            lock.release()
        return
    with closing(open_reader(url)) as connection:
        from truepose.storage.engine.postgresql_server import take_lock

        take_lock(connection, display_url(parsed_url(url)))
        yield connection


def library_errors(url: str) -> tuple[type[Exception], ...]:
    """Return what the library of an address raises."""
    if not is_server(parsed_url(url)):
        return (LIBRARY.DatabaseError,)
    from truepose.storage.engine.postgresql_connections import REFUSED

    return REFUSED


def require_answering(url: str, error: Exception) -> None:
    """Raise ServerAwayError where what a library raised says that there is no connection any more."""
    if is_server(parsed_url(url)):
        from truepose.storage.engine.postgresql_connections import has_ended, translate_error

        if has_ended(error):
            raise translate_error(display_url(parsed_url(url)), error) from error


def require_library() -> None:
    """Raise DatabaseAddressError where what speaks to a server is not installed."""
    if importlib.util.find_spec("psycopg") is None:
        raise DatabaseAddressError(
            "A PostgreSQL database needs psycopg; install it with: pip install 'truepose[postgresql]'."
        )
