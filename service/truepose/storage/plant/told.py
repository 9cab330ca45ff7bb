"""What results tell, kept beside them: from each page of a journal, and from what was collected before.

A plant of an earlier version kept the records and not what they tell. The link of the newest row says how far
a branch was read: pages come in order, and what was collected before is read before the next page is.
"""

import json
import logging
from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import Connection, func, select

from truepose.storage.leaving.typed_rows import untyped
from truepose.storage.plant.certificates import STATING, add_certificates, stated_certificates
from truepose.storage.plant.chains import newest_row
from truepose.storage.plant.records import Branch, CollectedLink
from truepose.storage.plant.telling import TELLING, UNKNOWN_FORM, Document, Telling, ToldKind, telling
from truepose.storage.rows import add_row
from truepose.storage.tables.of_plants import plant_journal, plant_results, plant_told

_LOG: Final = logging.getLogger(__name__)
_DAY: Final = 10  # letters of a date at the beginning of a time
_CARRIED: Final = ("tool", "base")  # what the robot was measured with: the same for all that was made of it


def tell(connection: Connection, branch: Branch, link: CollectedLink, row: Document) -> None:
    """Add what a record tells, inside the caller's transaction; what it is of was added before.

    One of a form that this version does not know tells nothing.
    """
    try:
        found, papers = telling(link.record, row), stated_certificates(link.record, row)
        if found is not None:
            _add(connection, branch, link, found, str(row["recorded_at"])[:_DAY])
        add_certificates(connection, branch, link, papers)
    except UNKNOWN_FORM as error:
        _LOG.warning("record %d of the %s tells nothing (%r)", link.record_id, link.record, error)


def untold_links(connection: Connection, branch_id: int) -> list[int]:
    """Return the links of a branch, in their order, whose records tell something that was not looked for."""
    told = select(func.max(plant_told.c.link)).where(plant_told.c.branch_id == branch_id)
    journal, last = plant_journal.c, int(connection.scalar(told) or 0)
    link = journal.link + 0  # not by the index of links: between two such records may lie a million others
    telling_records = journal.record.in_(sorted({*TELLING, *STATING}))
    query = select(journal.link).where(journal.branch_id == branch_id, telling_records, link > last)
    return [*connection.scalars(query.order_by(link))]


def tell_again(connection: Connection, branch: Branch, links: Sequence[int]) -> None:
    """Add what the records of some links tell."""
    journal = plant_journal.c
    columns = (journal.link, journal.stream, journal.record, journal.record_id, journal.hash, journal.content)
    query = select(*columns).where(journal.branch_id == branch.id, journal.link.in_(links))
    for row in connection.execute(query.order_by(journal.link)):
        link = _link(*row)
        if link.row is not None:
            tell(connection, branch, link, link.row)


def _link(
    link: int, stream: int, record: str, record_id: int, hashed: bytes, content: str | None
) -> CollectedLink:
    row = None if content is None else untyped(json.loads(content))
    return CollectedLink(link, stream, record, record_id, bytes(hashed), content, row)


def _add(connection: Connection, branch: Branch, link: CollectedLink, found: Telling, day: str) -> None:
    serial, measured_on = _of_whom(connection, branch, found.kind, link.record_id, day)
    carried = {} if found.made_of is None else _carried(connection, branch, *found.made_of)
    add_row(
        connection,
        plant_told,
        branch_id=branch.id,
        kind=found.kind,
        link=link.link,
        record_id=link.record_id,
        robot_serial_number=serial,
        measured_on=measured_on,
        verdict=found.verdict,
        figure_mm=found.figure_mm,
        limit_mm=found.limit_mm,
        document={**carried, **found.document},
    )


def _of_whom(
    connection: Connection, branch: Branch, kind: ToldKind, record_id: int, day: str
) -> tuple[str, str]:
    """Return serial number of the robot and day of measuring, as they stand beside the result.

    Which robot answers in a session is known with what is made of it.
    """
    if kind == "session":
        return "", day
    result = (plant_results.c.kind == kind) & (plant_results.c.record_id == record_id)
    found = newest_row(connection, branch, plant_results, result, by_link=True)
    return ("", "") if found is None else (found.robot_serial_number, found.measured_on)


def _carried(connection: Connection, branch: Branch, kind: ToldKind, record_id: int) -> dict[str, Any]:
    origin = (plant_told.c.kind == kind) & (plant_told.c.record_id == record_id)
    found = newest_row(connection, branch, plant_told, origin, by_link=True)
    told = {} if found is None else found.document
    return {name: told[name] for name in _CARRIED if name in told}
