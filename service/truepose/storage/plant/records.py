"""What the storage of a plant takes and hands out."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from enum import StrEnum
from typing import Any, Final, TypeAlias

Document: TypeAlias = Mapping[str, Any]
DAY: Final = 10  # letters of a date at the beginning of a time


@dataclass(frozen=True, slots=True)
class CollectedLink:
    """A link of a cell's chain that was verified, and its record where that left the cell."""

    link: int
    stream: int
    record: str
    record_id: int
    hash: bytes
    content: str | None = None  # of the record, as it came
    row: Mapping[str, Any] | None = None  # the same, read
    verified: bool = False  # False: without a row, or with a secret taken out of it


@dataclass(frozen=True, slots=True)
class ClockSeen:
    """The clock of a cell against the plant's, measured in one visit."""

    offset_s: float  # cell's less the plant's
    bound_s: float  # it is known within so much


@dataclass(frozen=True, slots=True)
class Branch:
    """A chain of a cell: the first one, or one that a person accepted after another was shown."""

    id: int
    cell_id: int
    segments: tuple[tuple[int, int | None], ...]  # branch and its last link that counts; oldest first


@dataclass(frozen=True, slots=True)
class AcceptedBranch:
    """Another chain of a cell, and who accepted it."""

    recorded_at: str
    after_link: int  # the last that it shares with the chain before it
    person: str
    reason: str


class Outcome(StrEnum):
    """What came of a visit."""

    WHOLE = "whole"  # all is collected
    UNREACHABLE = "unreachable"  # the cell does not answer as one
    REFUSED = "refused"  # a record is not that of its link
    ANOTHER_CHAIN = "another_chain"  # nothing is collected before a person has accepted it


@dataclass(frozen=True, slots=True)
class Visit:
    """One visit to a cell."""

    outcome: Outcome
    sentence: str = ""  # empty: nothing is amiss
    collected: int = 0  # links
    newest: int | None = None
    head: str | None = None  # of what was collected so far
    fork: int | None = None  # last link in common with another chain
    clock: ClockSeen | None = None
    version: str | None = None
    schema: str | None = None


@dataclass(frozen=True, slots=True)
class VisitRecord:
    """A visit as it was kept, and when the newest one after it found the same."""

    id: int
    recorded_at: str
    visit: Visit
    found_at: str  # since the start of the service; else when it was kept


class HandDownKind(StrEnum):
    """What can be handed down."""

    PLAN = "plan"
    MODEL = "model"


class HandDownState(StrEnum):
    """Where a hand-down stands."""

    WAITING = "waiting"  # for the next visit
    DELIVERED = "delivered"  # the cell has it on its disk
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class HandDown:
    """A plan or a model for a cell."""

    cell: str
    kind: HandDownKind
    name: str
    person: str
    document: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class HandDownRecord:
    """A hand-down and where it stands."""

    id: int
    recorded_at: str
    hand_down: HandDown
    state: HandDownState
    sentence: str
    number_in_cell: int | None
    state_since: str


def day_of(row: Document) -> str:
    """Return the day on which a record was written, by the cell's clock."""
    return str(row["recorded_at"])[:DAY]


def document_in(row: Document, column: str) -> Any:
    """Return the document that a record of a cell has in a column."""
    return json.loads(str(row[column]))


def day_said(text: str) -> str:
    """Return a day as a cell said it; empty: it said none, or something that is none."""
    try:
        # One campaign with a day that is none ended the comparison of all robots with a traceback (commit
        # 2a87c82f).
        return text if date.fromisoformat(text) else ""
    except ValueError:
        return ""
