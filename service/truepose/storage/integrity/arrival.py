"""How a database was left: what a service sees at once when it opens it, and what a verification adds."""

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.errors import DatabaseAddressError
from truepose.storage.integrity.condition import Condition
from truepose.storage.integrity.head import Head
from truepose.storage.integrity.seal import Left, Seal, digest
from truepose.storage.integrity.verification import Told, Verdict, missing_protection, opened, verify


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
    for finding in missing_protection(connection):
        condition.note_damage(finding, finding)
    if left is None:
        return
    if left.sha256 is not None and log_bytes:
        condition.note_damage("log", f"A log lies beside {file}, which was closed without one.")
    if not has_link(connection, left):
        condition.note_damage("newest", newest_missing(file))


def verify_left(file: Path, told: Told = lambda share: None, printed: Head | None = None) -> Verdict:
    """Return what `verify` finds, and whether the file is as the service before said that it left it.

    Raises DatabaseAddressError where there is no such file.
    """
    if not file.is_file():
        raise DatabaseAddressError(f"There is no database {file}.")
    left = Seal(file).left()
    verdict = verify(file, told, printed)
    return verdict if left is None else replace(verdict, findings=(*verdict.findings, *_against(file, left)))


def newest_missing(file: Path) -> str:
    """Return what is said where the database holds less than was kept."""
    return (
        f"The newest records of {file} are missing or not those that were kept. Where an older copy was "
        f"put back on purpose, remove {file}.seal and start the service again."
    )


def _against(file: Path, left: Left) -> Iterator[str]:
    if left.sha256 is not None and digest(file) != left.sha256:
        yield f"The file {file} was changed while no service had it open."
    with contextlib.suppress(LIBRARY.DatabaseError), contextlib.closing(opened(file)) as connection:
        if not has_link(connection, left):
            yield newest_missing(file)


def has_link(connection: Any, left: Left) -> bool:
    """Whether a database holds the newest link that it was left with."""
    row = connection.execute("SELECT hash FROM links WHERE id = ?", (left.link,)).fetchone()
    return left.link == 0 or (row is not None and row[0].hex() == left.hash)
