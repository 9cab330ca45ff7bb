"""Indices by which a long session answers as fast as a short one."""

from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Find the reading of a place, the number of points and the poses told of without reading the rest."""
    op.create_index("ix_readings_place", "readings", ["session_id", "config", "nest", "id"])
    op.create_index("ix_readings_counted", "readings", ["session_id", "kind", "supersedes"])
    op.create_index("ix_ballbar_entries_kind", "ballbar_entries", ["session_id", "kind", "step_id"])


def downgrade() -> None:
    """Do without."""
    op.drop_index("ix_ballbar_entries_kind", "ballbar_entries")
    op.drop_index("ix_readings_counted", "readings")
    op.drop_index("ix_readings_place", "readings")
