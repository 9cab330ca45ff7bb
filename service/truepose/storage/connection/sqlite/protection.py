"""What keeps records in a SQLite file from being changed, and what tells that some were."""

from collections.abc import Iterator
from typing import Any

from truepose.storage.migrations.triggers import ACTIONS, trigger, trigger_name
from truepose.storage.tables import metadata


def damaged_pages(connection: Any) -> Iterator[str]:
    """Yield what is wrong with the pages of the file."""
    for (said,) in connection.execute("PRAGMA integrity_check(5)"):
        if _text(said) != "ok":
            yield f"The pages of the database are damaged ({_text(said)})."


def missing_protection(connection: Any) -> list[str]:
    """Return what was dropped of tables and of the triggers that keep records from being changed."""
    schema = {
        _text(name): _text(sql or "")
        for name, sql in connection.execute("SELECT name, sql FROM sqlite_schema")
    }
    gone = [f"The table {table} is missing." for table in metadata.tables if table not in schema]
    for table in metadata.tables:
        for action in ACTIONS["sqlite"]:
            name = trigger_name(table, action)
            if schema.get(name) != trigger(table, action):
                gone.append(f"The trigger {name}, which keeps records from being changed, is not as it was.")
    return gone


def numbers_given(connection: Any) -> dict[str, int]:
    """Return the newest number that each table has given, also where the record is gone."""
    rows = connection.execute("SELECT name, seq FROM sqlite_sequence").fetchall()
    return {_text(name): given for name, given in rows}


def _text(value: Any) -> str:
    return value if isinstance(value, str) else bytes(value).decode(errors="replace")
