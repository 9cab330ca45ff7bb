"""The library's own connection, for what is asked of records as they are kept: value by value.

`execute(query, values)` takes `?` for values and gives back what can be fetched, on either engine.
"""

from typing import Any

from sqlalchemy import Connection


def plain(connection: Connection) -> Any:
    """Return the library's own connection, inside the transaction of `connection`."""
    return connection.connection.dbapi_connection
