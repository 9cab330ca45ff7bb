"""Triggers as a database keeps them: they refuse to change a record."""

from collections.abc import Mapping
from typing import Final

REFUSAL: Final = "records are appended or superseded, never changed"
ACTIONS: Final[Mapping[str, tuple[str, ...]]] = {
    "sqlite": ("update", "delete"),
    "postgresql": ("update", "delete", "truncate"),
}
FUNCTION: Final = "refuse_change"
# 23000: what it says of a record is what a constraint would
BODY: Final = f"BEGIN RAISE EXCEPTION '{REFUSAL}' USING ERRCODE = '23000'; END"


def trigger_name(table: str, action: str) -> str:
    """Return the name of the trigger that refuses `action`."""
    return f"{table}_no_{action}"


def triggers(engine: str, table: str) -> list[str]:
    """Return the statements that make a table append-only."""
    if engine == "sqlite":
        return [trigger(table, action) for action in ACTIONS[engine]]
    function = f"CREATE OR REPLACE FUNCTION {FUNCTION}() RETURNS trigger LANGUAGE plpgsql AS $${BODY}$$"
    return [function, *(server_trigger(table, action) for action in ACTIONS[engine])]


def trigger(table: str, action: str) -> str:
    """Return the trigger that refuses `action`, "update" or "delete", as SQLite keeps it."""
    return (
        f"CREATE TRIGGER {trigger_name(table, action)} BEFORE {action.upper()} ON {table} "
        f"BEGIN SELECT RAISE(ABORT, '{REFUSAL}'); END"
    )


def server_trigger(table: str, action: str) -> str:
    """Return the trigger that refuses `action`, "truncate" as well, as PostgreSQL keeps it."""
    each = "STATEMENT" if action == "truncate" else "ROW"
    return (
        f"CREATE TRIGGER {trigger_name(table, action)} BEFORE {action.upper()} ON {table} "
        f"FOR EACH {each} EXECUTE FUNCTION {FUNCTION}()"
    )
