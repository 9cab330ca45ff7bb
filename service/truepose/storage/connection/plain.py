"""The library's own connection, for what is asked of records as they are kept: value by value.

`execute(query, values)` takes `?` for values and gives back what can be fetched, on either engine. Texts come
as texts (or bytes not decoded yet, as bytearray), bytes as bytes, and JSON as the text that is kept.
"""

from typing import TYPE_CHECKING, Any, cast

from sqlalchemy import Connection

from truepose.storage.connection.sqlite import protection as of_file

if TYPE_CHECKING:
    import psycopg


def plain(connection: Connection) -> Any:
    """Return the library's own connection, inside the transaction of `connection`."""
    own = connection.connection.dbapi_connection
    if connection.dialect.name == "sqlite":
        return own
    from truepose.storage.connection.postgresql.plain import PlainConnection

    return PlainConnection(cast("psycopg.Connection[Any]", own))


def protection_of(connection: Any) -> Any:
    """Return the module that knows how the engine of a plain connection protects what it holds."""
    if not hasattr(connection, "server"):
        return of_file
    from truepose.storage.connection.postgresql import protection as of_server

    return of_server
