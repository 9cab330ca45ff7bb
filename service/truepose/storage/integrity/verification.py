"""Whether a database holds what was written: pages, protection, chain, and how a service left it.

Reads in small steps, each in a transaction of its own, so that a service that writes meanwhile is not held
up and its log not kept from being taken over; records that come meanwhile are checked like all others.

`python -m` this module is the process that looks through a database: its URL in, JSON lines out. The URL may
hold a password, so it is read and is no argument, which everybody on the machine can see.
"""

import contextlib
import json
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from truepose.storage.engine.address import database_file, display_address, is_server, parsed_url
from truepose.storage.engine.backend import Condition
from truepose.storage.engine.raw_connection import damaged_pages, missing_protection, numbers_given
from truepose.storage.engine.reading import library_errors, lies_beside, open_reader, require_answering
from truepose.storage.errors import DatabaseAddressError
from truepose.storage.integrity.database_identity import ClosingState, IdentityFile, digest_of, has_link
from truepose.storage.integrity.hash_chain import (
    GENESIS,
    OF_NO_SESSION,
    linked_hash,
    stream_of,
)
from truepose.storage.integrity.head_hash import Head, contradiction, newest_head
from truepose.storage.secret_files import is_taken_out
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
        with closing(open_reader(url)) as connection:
            damaged = tuple(damaged_pages(connection))
            if damaged:  # what such pages say need have no order and no end
                return Verdict(0, damaged)
            further = missing_protection(connection)
            told(0.1)
            chain = _ChainReader(connection)
            chain.read(lambda share: told(0.1 + 0.9 * share))
            if printed is not None and (said := contradiction(connection, printed)) is not None:
                further.append(said)
            findings = (*chain.findings[:_MOST_FINDINGS], *further)
            return Verdict(chain.records, findings, chain.newest, newest_head(connection))
    except library_errors(url) as error:
        require_answering(url, error)
        return Verdict(0, (f"The database cannot be read ({' '.join(str(error).split())}).",))


def findings_within(connection: Any, told: Told) -> list[str]:
    """Return what is wrong with any record, as a transaction sees it that is under way."""
    chain = _ChainReader(connection)
    chain.read_within(told)
    return [*chain.findings, *missing_protection(connection)]


def stream_findings(connection: Any, stream: int) -> Iterator[str]:
    """Yield what is wrong with the records of one session; nothing: they are as they were written."""
    before = GENESIS
    links = "SELECT record, record_id, hash FROM links WHERE stream = ? ORDER BY id"
    linked: Counter[str] = Counter()
    for record, record_id, found in connection.execute(links, (stream,)):
        if record in metadata.tables:
            linked[record] += 1
            rows = connection.execute(f'SELECT * FROM "{record}" WHERE id = ?', (record_id,))
            names, row = tuple(column[0] for column in rows.description), rows.fetchone()
            if row is None or linked_hash(before, record, names, row) != found:
                yield f"{_record(record, record_id, stream)} differs from what was written."
        before = found
    for record in ("readings", "session_entries"):
        held = connection.execute(f"SELECT count(*) FROM {record} WHERE session_id = ?", (stream,))
        if held.fetchone()[0] != linked[record]:
            yield f"Of the {_words(record)} of session {stream} some were inserted or removed."


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
        # A page that is not full reaches the newest link of now. What is written meanwhile comes in the
        # transaction below, where nothing can be added between links and records.
        while self._page() == _LINKS and len(self.findings) < _MOST_FINDINGS:
            told(min(1.0, self._last / max(newest, 1)))
        # Short: only what came since the last page. One transaction over everything would keep the log from
        # being taken over for as long as that takes.
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
            # Numbers of links have no gaps, also none behind refused records: a gap is a link that was taken
            # out.
            if number != self._last + 1:
                self.findings.append(f"Links {self._last + 1} to {number - 1} of the chain are missing.")
            self._last = number
            self._follow(stream, _text(record), record_id, bytes(found))
        return len(links)

    def _follow(self, stream: int, record: str, record_id: int, found: bytes) -> None:
        # The link as it is kept goes on, not the hash as it should be: one wrong record is one finding, and
        # not one for each record that follows.
        before, self._heads[stream] = self._heads.get(stream, GENESIS), found
        self.newest = (self._last, found.hex())
        self.records += 1
        table = self._tables.get(record)
        if table is None:
            self.findings.append(f"Link {self._last} of the chain names the unknown table {record}.")
            return
        row, slipped_in = table.row(record_id)
        self.findings += [
            f"{_record(record, n, None)} was inserted without a link in the chain." for n in slipped_in
        ]
        if row is None:
            self.findings.append(f"{_record(record, record_id, stream)} is missing.")
        elif (
            linked_hash(before, record, table.names, row) != found
            # A record that was moved to another session has a right hash in a wrong stream.
            or stream_of(record, table.names, row) != stream
        ) and not is_taken_out(record, table.names, row):
            self.findings.append(f"{_record(record, record_id, stream)} differs from what was written.")

    def _look_for_more(self) -> None:
        """Find records behind the newest link, and numbers that were given and are no longer there."""
        for record, table in self._tables.items():
            # Numbers above the newest link: nothing has linked them.
            self.findings += [
                f"{_record(record, n, None)} was inserted without a link in the chain." for n in table.left()
            ]
        last = {record: table.last for record, table in self._tables.items()} | {"links": self._last}
        for record, given in numbers_given(self._connection).items():
            # A newest record that was taken out together with its link leaves no gap. The engine still knows
            # which number it gave last.
            if last.get(record, given) != given:
                self.findings.append(
                    f"The newest {_words(record)} are missing: {given} numbers were assigned."
                )


class _Rows:
    """The records of one table in their order, read some at a time."""

    def __init__(self, connection: Any, record: str) -> None:
        self._connection = connection
        self._query = f'SELECT id, * FROM "{record}" WHERE id > ? ORDER BY id LIMIT ?'
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


def note_how_it_was_left(
    connection: Any, file: Path, left: ClosingState | None, log_bytes: int, condition: Condition
) -> None:
    """Note what was dropped, a log where there was none, and newest records that are no longer there.

    Parameters
    ----------
    connection : connection of the library
        That writes.
    file : Path
    left : ClosingState or None
        What the service before said; None where it said nothing.
    log_bytes : int
        Size of the write-ahead log before the database was opened.
    condition : Condition
    """
    for finding in missing_protection(connection):
        condition.note_damage(finding, finding)
    # Nobody has left it: a database from before there were seals, or one that a person put here.
    if left is None:
        return
    # A service that ends in order takes its log over and removes it; one that is there was put there, or
    # written by another program.
    if left.sha256 is not None and log_bytes:
        condition.note_damage("log", f"There is a log beside {file}, which was closed without one.")
    if not has_link(connection, left):
        condition.note_damage("newest", newest_missing(str(file), IdentityFile(file).file))


def verify_left(file: Path, told: Told = lambda share: None, printed: Head | None = None) -> Verdict:
    """Return what `verify_left_at` finds of a file of SQLite."""
    return verify_left_at(f"sqlite:///{file}", told, printed)


def verify_left_at(url: str, told: Told = lambda share: None, printed: Head | None = None) -> Verdict:
    """Return what `verify_at` finds, and whether the database is as the service before said that it left it.

    Raises DatabaseAddressError where there is no such file, StorageError where a server cannot be reached.
    """
    file, server = database_file(url), is_server(parsed_url(url))
    if not server and not file.is_file():
        raise DatabaseAddressError(f"There is no database {file}.")
    seal = IdentityFile(lies_beside(url))
    left = seal.left()
    # The seal was read before: a service that starts meanwhile writes another one.
    verdict = verify_at(url, told, printed)
    if left is None:
        return verdict
    return replace(verdict, findings=(*verdict.findings, *_against(url, left, seal.file)))


def newest_missing(where: str, seal: Path) -> str:
    """Return what is said where the database holds less than was kept."""
    return (
        f"The newest records of {where} are missing or were replaced. If an older copy was restored on"
        f" purpose, remove {seal} and start the service again."
    )


def _against(url: str, left: ClosingState, seal: Path) -> Iterator[str]:
    if left.sha256 is not None:
        file = database_file(url)
        if digest_of(file) != left.sha256:
            yield f"The file {file} was changed while no service had it open."
    with contextlib.suppress(*library_errors(url)), contextlib.closing(open_reader(url)) as connection:
        if not has_link(connection, left):
            yield newest_missing(display_address(url), seal)


_LOWEST_PRIORITY: Final = 19


def main() -> None:
    """Look through the database named and tell how far that is, then what was found."""
    if hasattr(os, "nice"):
        # A session measures beside it, and its readings come first.
        os.nice(_LOWEST_PRIORITY)
    verdict = verify_at(sys.stdin.readline().strip(), lambda share: _tell(share=round(share, 3)))
    _tell(share=1.0, findings=verdict.findings, records=verdict.records)


def _tell(**what: Any) -> None:
    sys.stdout.write(json.dumps(what) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
