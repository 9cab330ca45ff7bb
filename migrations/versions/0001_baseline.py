"""The schema with which the first release begins, in the words of each engine."""

from pathlib import Path
from typing import Final

import sqlalchemy as sa
from alembic import op

from truepose.storage.migrations.append_only import protect

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

_STATEMENTS: Final = Path(__file__).parent  # `python -m tests.studies.baseline` writes them


def upgrade() -> None:
    """Make all tables, and let none of their records be changed."""
    connection = op.get_bind()
    file = _STATEMENTS / f"0001_{connection.dialect.name}.sql"
    for statement in file.read_text(encoding="utf-8").split(";\n"):
        connection.exec_driver_sql(statement)
    for table in sa.inspect(connection).get_table_names():
        if table != "alembic_version":
            protect(table)


def downgrade() -> None:
    """Raise NotImplementedError: nothing came before it."""
    raise NotImplementedError("no release had a schema before this one")
