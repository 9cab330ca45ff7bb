"""The library's own connection, for what is asked of records as they are kept: value by value.

`execute(query, values)` takes `?` for values and gives back what can be fetched, on either engine. Texts come
as texts (or bytes not decoded yet, as bytearray), bytes as bytes, and JSON as the text that is kept.
"""

from collections.abc import Container, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, cast

from sqlalchemy import Connection

from truepose.storage.migrations.triggers import (
    ACTIONS,
    BODY,
    FUNCTION,
    server_trigger,
    trigger,
    trigger_name,
)
from truepose.storage.tables import metadata

if TYPE_CHECKING:
    import psycopg

_SERVER_TABLES: Final = "SELECT tablename FROM pg_tables WHERE schemaname = current_schema()"
# `tgenabled`: a trigger that somebody has disabled is still there, and keeps nothing.
_SERVER_TRIGGERS: Final = """
    SELECT tgname, pg_get_triggerdef(pg_trigger.oid, true) FROM pg_trigger
    JOIN pg_class ON pg_class.oid = tgrelid
    WHERE relnamespace = current_schema()::regnamespace AND NOT tgisinternal AND tgenabled IN ('O', 'A')
"""
_SERVER_FUNCTIONS: Final = (
    "SELECT prosrc FROM pg_proc WHERE proname = ? AND pronamespace = current_schema()::regnamespace"
)


def plain(connection: Connection) -> Any:
    """Return the library's own connection, inside the transaction of `connection`."""
    own = connection.connection.dbapi_connection
    if connection.dialect.name == "sqlite":
        return own
    # Only where there is a server: see `database.backend_of`.
    from truepose.storage.engine.postgresql_connections import PlainConnection

    return PlainConnection(cast("psycopg.Connection[Any]", own))


def damaged_pages(connection: Any) -> Iterator[str]:
    """Yield what is wrong with the pages of a file.

    A server has no check of all its pages that anybody may ask for: where it keeps checksums
    (`data_checksums`), it finds a wrong bit when it reads the page, and a verification reads every record.
    """
    if _of_server(connection):
        return
    # Five findings are enough to say that the file is damaged; a damaged one may have millions.
    for (said,) in connection.execute("PRAGMA integrity_check(5)"):
        if _text(said) != "ok":
            yield f"The pages of the database are damaged ({_text(said)})."


def missing_protection(connection: Any) -> list[str]:
    """Return what was dropped, or put out of force, of tables and of what keeps them append-only."""
    if _of_server(connection):
        return _missing_on_server(connection)
    schema = {
        _text(name): _text(sql or "")
        for name, sql in connection.execute("SELECT name, sql FROM sqlite_schema")
    }
    return _missing(
        schema,
        schema,
        {
            trigger_name(table, action): trigger(table, action)
            for table in metadata.tables
            for action in ACTIONS["sqlite"]
        },
    )


def _missing_on_server(connection: Any) -> list[str]:
    tables = {name for (name,) in connection.execute(_SERVER_TABLES)}
    triggers = dict(connection.execute(_SERVER_TRIGGERS).fetchall())
    gone = _missing(
        tables,
        triggers,
        {
            trigger_name(table, action): server_trigger(table, action)
            for table in metadata.tables
            for action in ACTIONS["postgresql"]
        },
    )
    # The triggers of a server call one function; replacing its body would put all of them out of force and
    # change none.
    if connection.execute(_SERVER_FUNCTIONS, (FUNCTION,)).fetchall() != [(BODY,)]:
        gone.append(f"The function {FUNCTION}, which protects records from changes, was altered.")
    return gone


def _missing(tables: Container[str], triggers: Mapping[str, str], wanted: Mapping[str, str]) -> list[str]:
    return [
        *(f"The table {table} is missing." for table in metadata.tables if table not in tables),
        *(
            f"The trigger {name}, which protects records from changes, was altered."
            for name, statement in wanted.items()
            if triggers.get(name) != statement
        ),
    ]


def numbers_given(connection: Any) -> dict[str, int]:
    """Return the newest number that each table has given, also where the record is gone.

    On a server a number is the newest one's and one more; there the noted newest link tells what is gone.
    """
    if _of_server(connection):
        return {}
    rows = connection.execute("SELECT name, seq FROM sqlite_sequence").fetchall()
    return {_text(name): given for name, given in rows}


def _of_server(connection: Any) -> bool:
    return hasattr(connection, "server")


def _text(value: Any) -> str:
    return value if isinstance(value, str) else bytes(value).decode(errors="replace")
