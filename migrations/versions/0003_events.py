"""Events to follow and resume, and the keys under which requests were answered."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables of the conversation with clients."""
    op.create_table(
        "events",
        number(),
        recorded(),
        sa.Column("kind", sa.Text, nullable=False),
        reference("session_id", "sessions", nullable=True),
        reference("job_id", "jobs", nullable=True),
        sa.Column("document", sa.JSON, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_events_session_id", "events", ["session_id", "kind", "id"])
    op.create_index("ix_events_job_id", "events", ["job_id", "kind", "id"])
    protect("events")
    op.create_table(
        "request_keys",
        sa.Column("key", sa.Text, primary_key=True),
        recorded(),
        sa.Column("fingerprint", sa.Text, nullable=False),
        sa.Column("resource", sa.Text, nullable=False),
        sa.Column("resource_id", sa.Integer, nullable=False),
    )
    protect("request_keys")


def downgrade() -> None:
    """Drop the tables of the conversation; measurements and results stay."""
    drop_protected("request_keys")
    drop_protected("events")
