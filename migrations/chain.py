"""The chain of records where a migration takes some away: it begins anew over those that stay."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.integrity.chain import link_all
from truepose.storage.migrations.append_only import delete_protected


def chained_tables() -> set[str]:
    """Return the tables whose records are in the chain."""
    return set(op.get_bind().execute(sa.text("SELECT DISTINCT record FROM links")).scalars())


def chain_anew(tables: set[str]) -> None:
    """Begin the chain anew with the records of these tables."""
    delete_protected("links", "true")
    op.execute("DELETE FROM sqlite_sequence WHERE name = 'links'")  # who verifies misses no number
    link_all(op.get_bind().connection.cursor(), sorted(tables))
