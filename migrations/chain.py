"""The chain of records where a migration takes some away: it begins anew over those that stay."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.connection.plain import plain
from truepose.storage.integrity.chain import link_all
from truepose.storage.migrations.append_only import delete_protected
from truepose.storage.migrations.columns import on_sqlite


def chained_tables() -> set[str]:
    """Return the tables whose records are in the chain."""
    return set(op.get_bind().execute(sa.text("SELECT DISTINCT record FROM links")).scalars())


def chain_anew(tables: set[str]) -> None:
    """Begin the chain anew with the records of these tables."""
    delete_protected("links", "true")
    if on_sqlite():
        op.execute("DELETE FROM sqlite_sequence WHERE name = 'links'")  # who verifies misses no number
    link_all(plain(op.get_bind()), sorted(tables))
