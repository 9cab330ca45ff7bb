"""One visit to a cell: clocks, the chain from where it was left, and what is handed down.

However a visit ends, what was kept of it is whole, and the next one goes on behind it.
"""

import asyncio
import logging
from dataclasses import dataclass, replace
from typing import Final

from truepose.plant.asking import AskedCell, CellHead
from truepose.plant.clocks import clock_seen
from truepose.plant.errors import CellAnswerError, CellSilentError
from truepose.plant.verification import verified
from truepose.storage.errors import (
    AnotherChainError,
    CollectedMeanwhileError,
    ConflictError,
    TamperedRecordError,
    UnreadableRowError,
)
from truepose.storage.plant.hand_downs import HandDownRepository
from truepose.storage.plant.journal import Collected, JournalRepository, Reached
from truepose.storage.plant.records import Branch, ClockSeen, HandDownState, Outcome, Visit

_LOG: Final = logging.getLogger(__name__)
_TIMES_ASKED: Final = 3  # for the time: one answer may come late
_LINKS: Final = 500  # a page


@dataclass(frozen=True, slots=True)
class Shelves:
    """What a visit writes into."""

    journal: JournalRepository
    hand_downs: HandDownRepository


async def visit(name: str, cell: AskedCell, shelves: Shelves) -> Visit:
    """Visit a cell and return what came of it; nothing is raised for what a cell can do wrong.

    Raises StorageError where the plant itself cannot keep what it collects, or has collected meanwhile.
    """
    begun = Visit(Outcome.WHOLE)
    reached = await shelves.journal.reached(name)
    try:
        head, clock = await _greeted(cell, reached)
        begun = replace(begun, clock=clock, newest=head.newest, version=head.version, schema=head.schema)
        known = await shelves.journal.collected(reached)
        begun = replace(begun, head=known.head.text)
        if head.newest < known.position or head.head != known.head.text:
            return await _another_chain(name, cell, known, shelves, begun)
        return await _collected(name, cell, known, shelves, begun)
    except CellAnswerError as error:
        return _so_far(shelves, reached.branch, begun, Outcome.UNREACHABLE, error)
    except (TamperedRecordError, UnreadableRowError) as error:
        return _so_far(shelves, reached.branch, begun, Outcome.REFUSED, error)
    except CollectedMeanwhileError:
        raise
    except ConflictError as error:
        _LOG.warning("a page of %s was refused", name, exc_info=True)
        unfit = ConflictError(f"{name} sends records that cannot be kept here: {error}")
        return _so_far(shelves, reached.branch, begun, Outcome.REFUSED, unfit)


async def _greeted(cell: AskedCell, reached: Reached) -> tuple[CellHead, ClockSeen]:
    heads = [await cell.head(reached.position) for _ in range(_TIMES_ASKED)]
    return heads[-1], clock_seen([head.clock for head in heads])


async def _collected(name: str, cell: AskedCell, known: Collected, shelves: Shelves, begun: Visit) -> Visit:
    position, heads, newest = known.position, known.heads, begun.newest or 0
    while position < newest:
        page = await cell.links(position, _LINKS)
        links, heads = await asyncio.to_thread(verified, page.lines, position, heads)
        if not links:
            raise CellAnswerError(f"{name} has {newest} links and sends none above {position}.")
        await shelves.journal.keep(known.branch, links, begun.clock)
        position, newest = links[-1].link, page.newest
    waits = await _handed_down(name, cell, shelves.hand_downs)
    collected, head = position - known.position, Collected(known.branch, position, heads).head
    return replace(begun, sentence=waits, collected=collected, newest=newest, head=head.text)


async def _handed_down(name: str, cell: AskedCell, hand_downs: HandDownRepository) -> str:
    """Hand down what waits, and return why some of it still does; empty: nothing does."""
    waits = ""
    for record in await hand_downs.waiting(name):
        try:
            handed = await cell.hand_down(record, f"hand-down-{record.id}-{record.recorded_at}")
        except CellAnswerError as error:
            waits = waits or f"All is collected, and hand-down {record.id} waits: {error}"
            if isinstance(error, CellSilentError):
                break
            continue
        state = HandDownState.REFUSED if handed.number is None else HandDownState.DELIVERED
        await hand_downs.note(record.id, state, handed.sentence, handed.number)
    return waits


def _so_far(shelves: Shelves, branch: Branch, begun: Visit, outcome: Outcome, error: Exception) -> Visit:
    head = shelves.journal.head(branch)
    return replace(begun, outcome=outcome, sentence=str(error), head=None if head is None else head.text)


async def _another_chain(
    name: str, cell: AskedCell, known: Collected, shelves: Shelves, begun: Visit
) -> Visit:
    """State that a cell shows another chain, and up to where the two are one."""
    common = await _last_in_common(
        cell, known.branch, min(known.position, begun.newest or 0), shelves.journal
    )
    error = AnotherChainError(
        f"{name} shows another chain than the one collected from it: {known.position} links were collected, "
        f"and only the first {common} are there as they were. Where a copy was put back or a disk exchanged, "
        "accept the other chain; else look which database the cell has open. Nothing is collected until then."
    )
    return replace(begun, outcome=Outcome.ANOTHER_CHAIN, sentence=str(error), fork=common)


async def _last_in_common(cell: AskedCell, branch: Branch, most: int, journal: JournalRepository) -> int:
    """Return the last link up to which both chains are one: the two part once and never meet again."""
    common, parted = 0, most + 1
    while parted - common > 1:
        middle = (common + parted) // 2
        there = await cell.head(middle)
        same = there.head == (await journal.head_at(branch, middle)).text
        common, parted = (middle, parted) if same else (common, middle)
    return common
