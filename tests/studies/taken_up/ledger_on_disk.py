"""The ledger as whoever opens the file finds it."""

import contextlib
import json
from pathlib import Path
from typing import Any

from truepose.storage.engine.sqlite_connections import LIBRARY

_NAMES = ("number", "step_id", "kind", "key", "document")


def lines(database: Path, after: int = 0) -> list[dict[str, Any]]:
    """Return the lines of all ledgers with a number above `after`, from the disk."""
    with contextlib.closing(LIBRARY.connect(f"file:{database}?mode=ro", uri=True)) as connection:
        query = "SELECT id, step_id, kind, key, document FROM session_entries WHERE id > ? ORDER BY id"
        rows = connection.execute(query, (after,)).fetchall()
    return [{**dict(zip(_NAMES, row, strict=True)), "document": _document(row[4])} for row in rows]


def _document(text: str) -> dict[str, Any]:
    """Return what a line says, with its text as clients are told it."""
    document = json.loads(text)
    said = document.get("text", "")
    state = document.get("entered")
    told = f"{state}: {said}" if state else said or document.get("control", "")
    return {**dict.fromkeys(("person", "length", "suspicion")), **document, "text": told}
