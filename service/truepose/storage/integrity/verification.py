"""Whether a database holds what was written: its pages, its protection, and the chain over all records.

Reads in small steps, each in a transaction of its own, so that a service that writes meanwhile is not held
up and its log not kept from being taken over; records that come meanwhile are checked like all others.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from truepose.storage.connection.plain import protection_of
from truepose.storage.connection.reading import opened_at, refused_by, require_answering
from truepose.storage.integrity.chain import (
    GENESIS,
    OF_NO_SESSION,
    TABLE_NOW,
    linked_hash,
    numbered,
    stream_of,
)
from truepose.storage.integrity.head import Head, contradicted, newest_head
from truepose.storage.integrity.taken_out import is_taken_out
from truepose.storage.tables import metadata, read_at_once

Told = Callable[[float], None]  # which share is done
_MOST_FINDINGS: Final = 20
_LINKS: Final = 2000  # at a time


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of a verification."""

    records: int
    findings: tuple[str, ...]  # one sentence each, the first ones; of records in the order of the chain
    newest: tuple[int, str] = (0, "")  # number and hash of the newest link
    head: Head | None = None  # None where the pages cannot be trusted


def verify(file: Path, told: Told = lambda share: None, printed: Head | None = None) -> Verdict:
    """Return what `verify_at` finds in a file of SQLite."""
    return verify_at(f"sqlite:///{file}", told, printed)


def verify_at(url: str, told: Told = lambda share: None, printed: Head | None = None) -> Verdict:
    """Return whether every page and every record of a database is as it was written.

    Where a `printed` head is given, also whether the database holds what that stands for. Raises StorageError
    where a server cannot be reached.
    """
    try:
        with closing(opened_at(url)) as connection:
            protection = protection_of(connection)
            damaged_pages = tuple(protection.damaged_pages(connection))
            if damaged_pages:  # what such pages say need have no order and no end
                return Verdict(0, damaged_pages)
            further = protection.missing_protection(connection)
            told(0.1)
            chain = _ChainReader(connection)
            chain.read(lambda share: told(0.1 + 0.9 * share))
            if printed is not None and (said := contradicted(connection, printed)) is not None:
                further.append(said)
            findings = (*chain.findings[:_MOST_FINDINGS], *further)
            return Verdict(chain.records, findings, chain.newest, newest_head(connection))
    except refused_by(url) as error:
        require_answering(url, error)
        return Verdict(0, (f"The database cannot be read ({' '.join(str(error).split())}).",))


def findings_within(connection: Any, told: Told) -> list[str]:
    """Return what is wrong with any record, as a transaction sees it that is under way."""
    chain = _ChainReader(connection)
    chain.read_within(told)
    return [*chain.findings, *protection_of(connection).missing_protection(connection)]


def stream_findings(connection: Any, stream: int) -> Iterator[str]:
    """Yield what is wrong with the records of one session; nothing: they are as they were written."""
    before = GENESIS
    links = "SELECT record, record_id, hash FROM links WHERE stream = ? ORDER BY id"
    linked: Counter[str] = Counter()
    for record, record_id, found in connection.execute(links, (stream,)):
        table = TABLE_NOW.get(record, record)
        if table in metadata.tables:
            linked[table] += 1
            rows = connection.execute(f'SELECT * FROM "{table}" WHERE {numbered(table)} = ?', (record_id,))
            names, row = tuple(column[0] for column in rows.description), rows.fetchone()
            if row is None or linked_hash(before, record, names, row) != found:
                yield f"{_record(record, record_id, stream)} is not as it was written."
        before = found
    for record in ("readings", "session_entries"):
        held = connection.execute(f"SELECT count(*) FROM {record} WHERE session_id = ?", (stream,))
        if held.fetchone()[0] != linked[record]:
            yield f"Of the {_words(record)} of session {stream} some were slipped in or taken out."


class _ChainReader:
    """Follows the links from the first to the newest, and the records beside them."""

    def __init__(self, connection: Any) -> None:
        self._connection = connection
        self._tables = {name: _Rows(connection, name) for name in metadata.tables if name != "links"}
        self._heads: dict[int, bytes] = {}
        self._last = 0
        self.newest = (0, "")
        self.records = 0
        self.findings: list[str] = []

    def read(self, told: Told) -> None:
        """Read everything; what came meanwhile is read to its end in one transaction."""
        newest = self._connection.execute("SELECT max(id) FROM links").fetchone()[0] or 0
        while self._page() == _LINKS and len(self.findings) < _MOST_FINDINGS:
            told(min(1.0, self._last / max(newest, 1)))
        self._connection.execute("BEGIN")
        self.read_within(told)
        self._connection.execute("ROLLBACK")

    def read_within(self, told: Told) -> None:
        """Read what is left, in a transaction of the caller's."""
        newest = self._connection.execute("SELECT max(id) FROM links").fetchone()[0] or 0
        while self._page() and len(self.findings) < _MOST_FINDINGS:
            told(min(1.0, self._last / max(newest, 1)))
        if len(self.findings) < _MOST_FINDINGS:
            self._look_for_more()

    def _page(self) -> int:
        query = "SELECT id, stream, record, record_id, hash FROM links WHERE id > ? ORDER BY id LIMIT ?"
        links = self._connection.execute(query, (self._last, _LINKS)).fetchall()
        for number, stream, record, record_id, found in links:
            if number != self._last + 1:
                self.findings.append(f"Links {self._last + 1} to {number - 1} of the chain are missing.")
            self._last = number
            self._follow(stream, _text(record), record_id, bytes(found))
        return len(links)

    def _follow(self, stream: int, record: str, record_id: int, found: bytes) -> None:
        before, self._heads[stream] = self._heads.get(stream, GENESIS), found
        self.newest = (self._last, found.hex())
        self.records += 1
        table = self._tables.get(TABLE_NOW.get(record, record))
        if table is None:
            self.findings.append(f"Link {self._last} of the chain names the unknown table {record}.")
            return
        row, slipped_in = table.row(record_id)
        self.findings += [f"{_record(record, n, None)} was slipped in." for n in slipped_in]
        if row is None:
            self.findings.append(f"{_record(record, record_id, stream)} is missing.")
        elif (
            linked_hash(before, record, table.names, row) != found
            or stream_of(record, table.names, row) != stream
        ) and not is_taken_out(record, table.names, row):
            self.findings.append(f"{_record(record, record_id, stream)} is not as it was written.")

    def _look_for_more(self) -> None:
        """Find records behind the newest link, and numbers that were given and are no longer there."""
        for record, table in self._tables.items():
            self.findings += [f"{_record(record, n, None)} was slipped in." for n in table.left()]
        last = {record: table.last for record, table in self._tables.items()} | {"links": self._last}
        for record, given in protection_of(self._connection).numbers_given(self._connection).items():
            if last.get(record, given) != given:
                self.findings.append(f"The newest {_words(record)} are missing: {given} were given a number.")


class _Rows:
    """The records of one table in their order, read some at a time."""

    def __init__(self, connection: Any, record: str) -> None:
        self._connection = connection
        number = numbered(record)
        self._query = f'SELECT {number}, * FROM "{record}" WHERE {number} > ? ORDER BY {number} LIMIT ?'
        self._some = read_at_once(record)
        self._ahead: list[Any] = []
        self.names: tuple[str, ...] = ()
        self.last = 0

    def row(self, number: int) -> tuple[Any, list[int]]:
        """Return a record, None where it is missing, and the numbers before it that nothing links to."""
        skipped = []
        while (row := self._next()) is not None and row[0] < number:
            skipped.append(row[0])
            self._take()
        if row is None or row[0] != number:
            return None, skipped
        self._take()
        return row[1:], skipped

    def left(self) -> list[int]:
        """Return the numbers of some records that are left."""
        left: list[int] = []
        while (row := self._next()) is not None:
            if len(left) < _MOST_FINDINGS:
                left.append(row[0])
            self._take()
        return left

    def _next(self) -> Any:
        if not self._ahead:
            rows = self._connection.execute(self._query, (self.last, self._some))
            self.names = tuple(column[0] for column in rows.description)[1:]
            self._ahead = rows.fetchall()[::-1]
        return self._ahead[-1] if self._ahead else None

    def _take(self) -> None:
        self.last = self._ahead.pop()[0]


def _record(record: str, number: int, stream: int | None) -> str:
    of = f" of session {stream}" if stream not in {None, OF_NO_SESSION} else ""
    return f"Record {number} of the {_words(record)}{of}"


def _words(record: str) -> str:
    return record.replace("_", " ")


def _text(value: Any) -> str:
    return value if isinstance(value, str) else bytes(value).decode(errors="replace")
