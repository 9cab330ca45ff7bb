"""Triggers as a database keeps them: they refuse to change a record."""


def trigger_name(table: str, action: str) -> str:
    """Return the name of the trigger that refuses `action`."""
    return f"{table}_no_{action}"


def trigger(table: str, action: str) -> str:
    """Return the trigger that refuses `action`, "update" or "delete", as the database keeps it."""
    return (
        f"CREATE TRIGGER {trigger_name(table, action)} BEFORE {action.upper()} ON {table} "
        "BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END"
    )
