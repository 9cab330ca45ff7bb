"""What copies are wanted; commands state it and must not wait for a database library."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class BackupPlan:
    """Where copies go, how often one is made, and how many are kept."""

    folder: Path
    every_s: float = 24 * 3600.0
    keep: int = 7
