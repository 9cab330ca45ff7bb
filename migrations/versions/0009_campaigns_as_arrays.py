"""Campaigns as arrays; those that are there stay in the zip of their folder."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import BYTES

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make room beside the zip."""
    op.add_column("campaigns", sa.Column("campaign", BYTES, nullable=True))


def downgrade() -> None:
    """Do without, as long as nothing is there: the chain of records rests on it."""
    if op.get_bind().scalar(sa.text("SELECT count(campaign) FROM campaigns")):
        raise ValueError("The program of schema 0008 cannot read the campaigns of this database; keep 0009.")
    op.drop_column("campaigns", "campaign")
