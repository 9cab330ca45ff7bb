"""Every record of a database, into an empty one of either engine, with its number and its link.

What is read is one moment of the source. All of it goes in one transaction, within which the chain is
followed once more on what was written: whatever ends the copying before that leaves the target as empty as it
was, and it can be begun anew. What reads the source holds the lock on it, as what writes the target holds the
one on that: neither lock is lost while the copying goes on.
"""

import contextlib
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from truepose.messages.message import Text
from truepose.storage.backup.copying import copy_drafts, restore_drafts
from truepose.storage.database import backend_of
from truepose.storage.engine.address import database_file, display_address, is_server, parsed_url
from truepose.storage.engine.backend import Condition, DatabaseBackend
from truepose.storage.engine.reading import library_errors, lies_beside, locked_for_reading, open_reader
from truepose.storage.engine.schema import newest_revision
from truepose.storage.engine.sqlite_connections import LIBRARY, opened_file
from truepose.storage.errors import BackupError, DatabaseAddressError, DatabaseUsedError, NewerSchemaError
from truepose.storage.integrity.head_hash import Head, newest_head
from truepose.storage.integrity.verification import findings_within
from truepose.storage.secret_files import without_pin
from truepose.storage.tables import metadata, read_at_once


def fill_in(connection: Any, record: str, names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Add rows to a table of the database that a plain connection writes; raises what its library raises."""
    columns = ", ".join(f'"{name}"' for name in names)
    # COPY sends the rows of a table in one exchange with the server; each row by itself costs a round trip.
    if hasattr(connection, "server"):
        connection.copy_in(f'COPY "{record}" ({columns}) FROM STDIN', rows)
    else:
        values = ", ".join("?" for _ in names)
        connection.executemany(f'INSERT INTO "{record}" ({columns}) VALUES ({values})', rows)


Told = Callable[[float, Text], None]  # which share is done, and of what
_WRITING: Final = 0.5  # of the time that everything takes


def transfer(source: str, target: str, told: Told = lambda share, doing: None) -> tuple[Head, int]:
    """Copy a database that no service has into an empty one; returns the head of the chain and the drafts.

    Raises
    ------
    DatabaseInUseError
        A service has one of the two.
    DatabaseUsedError
        Records are in the target.
    BackupError
        What was written is not what was read, or an engine refuses; or the records are there, and the drafts
        beside them are not.
    StorageError
        One of the two is no database of ours, or cannot be reached.
    """
    beside = _two(source, target)
    # Both locks are held to the end. A lock on a connection of its own was once lost without a word while a
    # second service got the source (commit 3202a630).
    with locked_for_reading(source) as locked, _newest(source, locked) as connection:
        return _fill(source, connection, target, told), _bring_drafts(*beside)


@contextlib.contextmanager
def snapshot(url: str) -> Iterator[str]:
    """Yield the address of a copy of a database as it is at this moment, which stays as it is; for readers.

    The copy is a file of the newest schema. Raises StorageError.
    """
    _require_there(url)
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        copy = Path(folder) / "copy.sqlite3"
        with closing(open_reader(url)) as connection:
            _require_readable(url, _schema(url, connection))
        if is_server(parsed_url(url)):
            fill(url, f"sqlite:///{copy}")
        else:
            _copy_file(database_file(url), copy)
        yield f"sqlite:///{copy}"


def fill(source: str, target: str, told: Told = lambda share, doing: None) -> Head:
    """Copy what a database holds at this moment, also while a service writes to it; raises as `transfer`."""
    with closing(open_reader(source)) as connection:
        return _fill(source, connection, target, told)


def _fill(source: str, connection: Any, target: str, told: Told) -> Head:
    refused: tuple[type[Exception], ...] = (*library_errors(source), *library_errors(target), ValueError)
    # Nobody reads the target yet, so nobody has to be kept from reading it.
    backend = backend_of(target, Condition(), contextlib.nullcontext)
    backend.open()
    try:
        # After opening, hence behind the lock: a service that starts meanwhile could have written the first
        # record.
        _require_empty(backend)
        return _filled(connection, backend, told)
    except refused as error:
        where, said = f"{display_address(source)} cannot be copied to {display_address(target)}", str(error)
        raise BackupError(f"{where} ({' '.join(said.split())}); nothing was kept.") from error
    finally:
        backend.close()


def _filled(source: Any, backend: DatabaseBackend, told: Told) -> Head:
    """Write everything in one transaction, and look through it before it counts."""
    target = backend.plain
    # One reading transaction for all tables: records of one moment, whose links and whose head agree.
    source.execute("BEGIN")
    target.execute("BEGIN")
    try:
        head = newest_head(source)
        _copy_tables(source, target, max(head.links, 1), told)
        _require_same(source, target, head, told)
        # Asked last, before the commit counts: with the connection its lock has gone, and somebody else may
        # have written to the source since it was read, or to the target.
        for each in (source, target):  # a connection that has ended does not answer, and its lock is gone
            each.execute("SELECT 1")
    except BaseException:
        # BaseException, since an interrupted copy has to leave the target as empty as it was: half of the
        # records with half of the chain would look like a database.
        target.execute("ROLLBACK")
        raise
    _commit(backend)
    told(1.0, "verified")
    return head


def _commit(backend: DatabaseBackend) -> None:
    """Commit; raises BackupError where nobody knows whether that was done, and what the library raises."""
    try:
        backend.plain.execute("COMMIT")
    except backend.refused as error:
        if not backend.ended(error):
            raise
        raise BackupError(
            f"The connection to {backend.where} ended during the commit: it now holds every record, or none; "
            "check with 'truepose verify'."
        ) from error


def _copy_tables(source: Any, target: Any, links: int, told: Told) -> None:
    done = 0
    # In the order of foreign keys: a server checks each row as it comes.
    for table in metadata.sorted_tables:
        names = [column.name for column in table.columns]
        for rows in _rows(source, table.name, names):
            fill_in(target, table.name, names, rows)
            done += len(rows)
            told(_WRITING * min(1.0, done / (2 * links)), "copying")  # a link for each record


def _rows(source: Any, record: str, names: list[str]) -> Iterator[list[Sequence[Any]]]:
    """Yield the rows of a table by their numbers, some at a time, without PINs."""
    # By number and not by OFFSET, which reads all rows before once more for each part; and a campaign at a
    # time, since a record may have many megabytes.
    last, some = 0, read_at_once(record)
    columns = ", ".join(f'"{name}"' for name in ("id", *names))
    query = f'SELECT {columns} FROM "{record}" WHERE id > ? ORDER BY id LIMIT ?'
    while rows := source.execute(query, (last, some)).fetchall():
        last = rows[-1][0]
        yield [without_pin(record, names, [_decoded(value) for value in row[1:]]) for row in rows]


def _decoded(value: Any) -> Any:
    return (
        value.decode() if isinstance(value, bytearray) else value
    )  # texts of a file, as they are read from outside


def _require_same(source: Any, target: Any, head: Head, told: Told) -> None:
    """Raise BackupError where the target does not hold what the source does."""
    for table in metadata.sorted_tables:
        counts = [
            one.execute(f'SELECT count(*) FROM "{table.name}"').fetchone()[0] for one in (source, target)
        ]
        if counts[0] != counts[1]:
            raise BackupError(f"{counts[1]} of {counts[0]} {table.name} arrived; nothing was kept.")
    # The target's chain is followed on what it gives back, not on what was sent: a value that an engine keeps
    # otherwise than it was given changes its hash.
    findings = findings_within(target, lambda share: told(_WRITING + (1 - _WRITING) * share, "verifying"))
    if findings or newest_head(target) != head:
        said = findings[0] if findings else "The newest records are not those of the database."
        raise BackupError(f"The copy failed verification: {said} Nothing was kept.")


def _two(source: str, target: str) -> tuple[Path, Path]:
    """Return what lies beside each is named after; raises BackupError where they are one database."""
    # SQLite would make an empty database of a name that was mistyped.
    _require_there(source)
    beside = lies_beside(source), lies_beside(target)
    # By what the servers say of themselves: two addresses of one database differ in every letter (decision
    # 0068).
    if beside[0] == beside[1]:
        raise BackupError(f"{display_address(source)} is both source and target; choose another target.")
    return beside


def _require_there(url: str) -> None:
    if not is_server(parsed_url(url)) and not database_file(url).is_file():
        raise DatabaseAddressError(f"There is no database {database_file(url)}.")


def _require_empty(backend: DatabaseBackend) -> None:
    """Raise DatabaseUsedError where there is any record."""
    for table in metadata.sorted_tables:
        if backend.plain.execute(f'SELECT 1 FROM "{table.name}" LIMIT 1').fetchone() is not None:
            raise DatabaseUsedError(f"{backend.where} already contains records; choose an empty database.")


@contextlib.contextmanager
def _newest(url: str, connection: Any) -> Iterator[Any]:
    """Yield what reads a database of the newest schema: of a copy, where the file has an older one."""
    schema = _schema(url, connection)
    if schema == newest_revision():
        yield connection
        return
    # A file of an older schema is brought up to date in a copy, so that the source is never changed; a server
    # has no such copy.
    _require_readable(url, schema)
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        copy = Path(folder) / "copy.sqlite3"
        _copy_file(database_file(url), copy)
        with closing(opened_file(copy)) as newest:
            yield newest


def _require_readable(url: str, schema: str) -> None:
    """Raise BackupError for a server of an older schema, which is brought up to date in place only."""
    if is_server(parsed_url(url)) and schema != newest_revision():
        raise BackupError(
            f"{display_address(url)} has schema {schema}; start the service of this version with it first."
        )


def _copy_file(older: Path, copy: Path) -> None:
    """Copy a file as it is at this moment, and bring the copy up to date."""
    with closing(opened_file(older)) as source, closing(LIBRARY.connect(copy)) as written:
        source.backup(written)
    backend = backend_of(f"sqlite:///{copy}", Condition(), contextlib.nullcontext)
    backend.open()
    backend.close()


def _schema(url: str, connection: Any) -> str:
    try:
        found = connection.execute("SELECT version_num FROM alembic_version").fetchone()
    except library_errors(url) as error:
        raise BackupError(f"{display_address(url)} is not a truepose database ({error}).") from error
    schema = found[0] if isinstance(found[0], str) else bytes(found[0]).decode()
    # Revisions are numbered with leading zeros, so the order of the texts is that of the schemas.
    if schema > newest_revision():
        raise NewerSchemaError(f"{display_address(url)} has schema {schema}, which a newer version wrote.")
    return schema


def _bring_drafts(source: Path, target: Path) -> int:
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        copy = Path(folder) / "copy"
        copy_drafts(source, copy)
        return restore_drafts(copy, target)
