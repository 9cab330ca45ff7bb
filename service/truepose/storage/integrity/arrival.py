"""How a database was left: what a service sees at once when it opens it, and what a verification adds."""

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from truepose.storage.connection.address import database_file, is_server, parsed_url, shown_address
from truepose.storage.connection.plain import protection_of
from truepose.storage.connection.reading import lies_beside, opened_at, refused_by
from truepose.storage.errors import DatabaseAddressError
from truepose.storage.integrity.condition import Condition
from truepose.storage.integrity.head import Head
from truepose.storage.integrity.seal import Left, Seal, digest, has_link
from truepose.storage.integrity.verification import Told, Verdict, verify_at


def note_how_it_was_left(
    connection: Any, file: Path, left: Left | None, log_bytes: int, condition: Condition
) -> None:
    """Note what was dropped, a log where there was none, and newest records that are no longer there.

    Parameters
    ----------
    connection : connection of the library
        That writes.
    file : Path
    left : Left or None
        What the service before said; None where it said nothing.
    log_bytes : int
        Size of the write-ahead log before the database was opened.
    condition : Condition
    """
    for finding in protection_of(connection).missing_protection(connection):
        condition.note_damage(finding, finding)
    if left is None:
        return
    if left.sha256 is not None and log_bytes:
        condition.note_damage("log", f"A log lies beside {file}, which was closed without one.")
    if not has_link(connection, left):
        condition.note_damage("newest", newest_missing(str(file), Seal(file).file))


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
    seal = Seal(lies_beside(url))
    left = seal.left()
    verdict = verify_at(url, told, printed)
    if left is None:
        return verdict
    return replace(verdict, findings=(*verdict.findings, *_against(url, left, seal.file)))


def newest_missing(where: str, seal: Path) -> str:
    """Return what is said where the database holds less than was kept."""
    return (
        f"The newest records of {where} are missing or not those that were kept. Where an older copy was "
        f"put back on purpose, remove {seal} and start the service again."
    )


def _against(url: str, left: Left, seal: Path) -> Iterator[str]:
    file = database_file(url)
    if left.sha256 is not None and digest(file) != left.sha256:
        yield f"The file {file} was changed while no service had it open."
    with contextlib.suppress(*refused_by(url)), contextlib.closing(opened_at(url)) as connection:
        if not has_link(connection, left):
            yield newest_missing(shown_address(url), seal)
