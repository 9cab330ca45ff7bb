"""Triggers that make a table append-only: a record is superseded by a further one, never changed."""

from alembic import op


def protect(table: str) -> None:
    """Refuse UPDATE and DELETE on `table` inside the database, whoever asks."""
    for action in ("update", "delete"):
        op.execute(
            f"CREATE TRIGGER {table}_no_{action} BEFORE {action.upper()} ON {table} "
            "BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END"
        )


def drop_protected(table: str) -> None:
    """Drop `table` with its triggers."""
    for action in ("update", "delete"):
        op.execute(f"DROP TRIGGER {table}_no_{action}")
    op.drop_table(table)
