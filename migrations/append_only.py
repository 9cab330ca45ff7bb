"""Triggers that make a table append-only: a record is superseded by a further one, never changed."""

from alembic import op

from truepose.storage.migrations.triggers import ACTIONS, trigger_name, triggers


def protect(table: str) -> None:
    """Refuse UPDATE and DELETE on `table` inside the database, whoever asks."""
    for statement in triggers(op.get_bind().dialect.name, table):
        op.execute(statement)


def drop_protected(table: str) -> None:
    """Drop `table` with its triggers."""
    unprotect(table)
    op.drop_table(table)


def delete_protected(table: str, condition: str) -> None:
    """Delete what an older schema has no words for, on the way down."""
    unprotect(table)
    op.execute(f"DELETE FROM {table} WHERE {condition}")
    protect(table)


def unprotect(table: str) -> None:
    """Drop the triggers of `table`."""
    engine = op.get_bind().dialect.name
    of = "" if engine == "sqlite" else f" ON {table}"
    for action in ACTIONS[engine]:
        op.execute(f"DROP TRIGGER {trigger_name(table, action)}{of}")
