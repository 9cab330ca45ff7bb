"""Columns that every record has, as the migrations write them."""

import sqlalchemy as sa


def number() -> sa.Column[int]:
    """Return the record's number; never given twice, even after the newest row is gone."""
    return sa.Column("id", sa.Integer, primary_key=True, autoincrement=True)


def recorded() -> sa.Column[str]:
    """Return when the record was written: UTC, ISO 8601."""
    return sa.Column("recorded_at", sa.Text, nullable=False)


def reference(name: str, target: str, *, nullable: bool = False) -> sa.Column[int]:
    """Return a reference to the number of a record in `target`."""
    return sa.Column(name, sa.Integer, sa.ForeignKey(f"{target}.id"), nullable=nullable)
