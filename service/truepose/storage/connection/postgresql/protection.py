"""What keeps records on a server from being changed, and what tells that some were.

A server has no check of all its pages that anybody may ask for: where it keeps checksums (`data_checksums`),
it finds a wrong bit when it reads the page, and a verification reads every record.
"""

from collections.abc import Iterator
from typing import Any, Final

from truepose.storage.migrations.triggers import ACTIONS, BODY, FUNCTION, server_trigger, trigger_name
from truepose.storage.tables import metadata

_TABLES: Final = "SELECT tablename FROM pg_tables WHERE schemaname = current_schema()"
_TRIGGERS: Final = """
    SELECT tgname, pg_get_triggerdef(pg_trigger.oid, true) FROM pg_trigger
    JOIN pg_class ON pg_class.oid = tgrelid
    WHERE relnamespace = current_schema()::regnamespace AND NOT tgisinternal AND tgenabled IN ('O', 'A')
"""
_BODIES: Final = (
    "SELECT prosrc FROM pg_proc WHERE proname = ? AND pronamespace = current_schema()::regnamespace"
)


def damaged_pages(connection: Any) -> Iterator[str]:
    """Yield nothing: what a server finds of its pages it says when it reads them."""
    yield from ()


def missing_protection(connection: Any) -> list[str]:
    """Return what was dropped, or put out of force, of tables and of what keeps them append-only."""
    tables = {name for (name,) in connection.execute(_TABLES)}
    triggers = dict(connection.execute(_TRIGGERS).fetchall())
    gone = [f"The table {table} is missing." for table in metadata.tables if table not in tables]
    for table in metadata.tables:
        for action in ACTIONS["postgresql"]:
            name = trigger_name(table, action)
            if triggers.get(name) != server_trigger(table, action):
                gone.append(f"The trigger {name}, which keeps records from being changed, is not as it was.")
    if connection.execute(_BODIES, (FUNCTION,)).fetchall() != [(BODY,)]:
        gone.append(f"The function {FUNCTION}, which keeps records from being changed, is not as it was.")
    return gone


def numbers_given(connection: Any) -> dict[str, int]:
    """Return nothing: a number is the newest one's and one more; the noted newest link tells what is gone."""
    return {}
