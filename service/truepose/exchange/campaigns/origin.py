"""What `campaign.json` says of all its readings: whether they are simulated, and of which day they are."""

from collections.abc import Iterable
from datetime import date
from typing import Final

from truepose.exchange.document import Node

_NOTED: Final = "SIMULATED:"


def read_simulated(root: Node, notes: Iterable[str]) -> bool | None:
    """Return what the description says; older archives of this program say it in a note. None: nothing."""
    said = root.optional("simulated")
    if said is not None:
        return said.truth()
    return True if any(note.startswith(_NOTED) for note in notes) else None


def read_day(node: Node) -> date:
    """Return the day here."""
    text = node.text()
    try:
        day = date.fromisoformat(text)
    except ValueError:
        node.fail(f"{text!r} is no day; one as 2026-03-03 is required")
    if day.isoformat() != text:  # of other ways to write a day, such as weeks
        node.fail(f"{text!r} is no day as 2026-03-03")
    return day
