"""Triggers that make a table append-only: a record is superseded by a further one, never changed."""

from alembic import op

from truepose.storage.migrations.triggers import trigger, trigger_name


def protect(table: str) -> None:
    """Refuse UPDATE and DELETE on `table` inside the database, whoever asks."""
    for action in ("update", "delete"):
        op.execute(trigger(table, action))


def drop_protected(table: str) -> None:
    """Drop `table` with its triggers."""
    _unprotect(table)
    op.drop_table(table)


def delete_protected(table: str, condition: str) -> None:
    """Delete what an older schema has no words for, on the way down."""
    _unprotect(table)
    op.execute(f"DELETE FROM {table} WHERE {condition}")
    protect(table)


def _unprotect(table: str) -> None:
    for action in ("update", "delete"):
        op.execute(f"DROP TRIGGER {trigger_name(table, action)}")
