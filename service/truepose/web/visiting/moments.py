"""Moments as people read them."""

from datetime import UTC, datetime


def moment(said: str) -> str:
    """Return a day as it is, and a time to the minute: nobody reads milliseconds."""
    if "T" not in said:
        return said
    return datetime.fromisoformat(said).astimezone(UTC).strftime("%Y-%m-%d %H:%M UTC")
