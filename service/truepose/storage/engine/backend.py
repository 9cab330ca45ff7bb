"""A database of either engine as the service holds it: the seam between storage and engines.

Each engine has its files beside this one (`sqlite`, `postgresql`). Nobody else asks which of them it is.
"""

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from sqlalchemy import Connection, Engine
from sqlalchemy.engine import Transaction

from truepose.storage.errors import StorageError
from truepose.storage.integrity.database_identity import ClosingState, has_link

Integrity: TypeAlias = Literal["not_checked", "checking", "whole", "damaged"]
RESERVE_IN_USE: Final = (
    "The disk is full; work in progress finishes with a reserve of 16 MB, and nothing new starts until"
    " there is space."
)
FOREIGN: Final = "foreign"  # damage that a verification clears


class Condition:
    """Told by the threads of the database, asked by everybody."""

    def __init__(self) -> None:
        # For the dictionary alone: it is iterated while other threads add to it. The other fields are single
        # assignments.
        self._turn = threading.Lock()
        self._damage: dict[str, str] = {}  # by what was found, in the order of finding
        self._checked: Integrity = "not_checked"
        self.verified_share = 0.0  # of the verification under way, or of the last one
        self.unchecked: str | None = None  # why the last verification came to no end; None where it did
        self.trouble: str | None = None  # why records are refused; None while they are taken
        self.low: str | None = None  # why nothing new begins, while records are taken

    @property
    def fault(self) -> str | None:
        """One sentence on what is amiss; None where nothing is."""
        return " ".join(told for told in (self.trouble, self.low, self.damage) if told) or None

    @property
    def damage(self) -> str | None:
        """One sentence on what was found that should not be; None where nothing was."""
        with self._turn:
            found = [*self._damage.values()]
        if not found:
            return None
        more = f" ({len(found) - 1} more like this.)" if len(found) > 1 else ""
        return f"{found[0]}{more}"

    @property
    def integrity(self) -> Integrity:
        """Whether the database is known to hold what was written."""
        return "damaged" if self._damage else self._checked

    @property
    def damaged(self) -> bool:
        """Whether anything was found."""
        return bool(self._damage)

    def note_damage(self, what: str, sentence: str) -> None:
        """Keep what was found; once for each `what`."""
        with self._turn:
            # Once for each finding: the same one comes every second while it lasts, and the first sentence
            # has its numbers.
            self._damage.setdefault(what, sentence)

    def begin_verification(self) -> None:
        """Say that everything is being looked through."""
        self._checked, self.verified_share = "checking", 0.0

    def end_verification(self, *, whole: bool) -> None:
        """Say what came of it: what others wrote has changed no record where everything is whole."""
        self._checked, self.verified_share, self.unchecked = "whole" if whole else "damaged", 1.0, None
        if whole:
            with self._turn:
                # Only this one is cleared: that others wrote is a doubt, which a look at every record
                # settles. Missing protection, a broken seal or a wrong record stay damage however often the
                # rest is found whole.
                self._damage.pop(FOREIGN, None)

    def give_up_verification(self, why: str) -> None:
        """Say that nobody knows what would have come of it: no doubt is settled."""
        self._checked, self.unchecked = "not_checked", why


READERS: Final = 4  # as many queries at a time as a handful of browsers asks for
Alone = Callable[[], AbstractContextManager[None]]  # while it lasts nobody reads


# No StorageError: it never leaves the storage, which answers only once the doubt is over.
class InDoubtError(Exception):
    """The connection ended during a commit: whether the server has made it shows when it is back."""

    def __init__(self, newest: ClosingState) -> None:
        super().__init__("The connection ended during a commit.")
        self.newest = newest  # link, which the database has then and only then


@dataclass(frozen=True, slots=True)
class DatabaseObservation:
    """What a look at the open database finds."""

    foreign: bool  # somebody else has written since the last look
    missing: tuple[str, ...]  # of its protection


class DatabaseBackend(ABC):
    """A database that this service holds: a connection that writes, some that read, and the lock.

    Everything happens on the writer's thread, except where it says otherwise.
    """

    refused: tuple[type[Exception], ...]  # what the library raises
    connection: Connection  # that writes
    readers: Engine  # of connections that see the last commit and cannot write; for any thread

    def __init__(self, url: str, file: Path, where: str, condition: Condition, alone: Alone) -> None:
        self.url = url
        self.file = file  # the database; of a server's, once open, what on this machine is named after it
        self.where = where  # the database, as people are told of it
        self.condition = condition
        self._alone = alone
        self.server_doubts: tuple[str, ...] | None = None  # settings that are off there; None: a file

    @abstractmethod
    def open(self) -> str:
        """Take the lock, open everything, bring the schema up to date and return it; raises StorageError."""

    @abstractmethod
    def make_ready(self) -> None:
        """See, before each transaction, that the database can be written, and mend what can be mended.

        Raises StorageError and what the library raises.
        """

    @abstractmethod
    def require_ours(self) -> None:
        """See, once it is ready again, that nobody else has written meanwhile; raises StorageError."""

    @abstractmethod
    def commit(self, transaction: Transaction, newest: ClosingState) -> None:
        """Commit and note the newest link; raises InDoubtError and what the library raises."""

    def has(self, newest: ClosingState) -> bool:
        """Whether the database has a link."""
        return has_link(self.plain, newest)

    @property
    @abstractmethod
    def plain(self) -> Any:
        """The connection that writes as the library has it (`connection.plain`), outside transactions."""

    @abstractmethod
    def translated(self, error: Exception) -> StorageError:
        """Return what the library raised as an error of the storage; on any thread."""

    def ended(self, error: Exception) -> bool:
        """Whether what the library raised says that a connection has ended; on any thread."""
        # One to a file never does by itself.
        return False

    def make_room(self, error: Exception) -> bool:
        """Give up the reserve where the library found no room; returns whether there was any."""
        # The disk of a server is the server's: it has no reserve.
        return False

    @abstractmethod
    def keep_reserve(self) -> None:
        """Take the reserve back once there is room."""

    @property
    def reserve_used(self) -> bool:
        """Whether the reserve is given up; on any thread."""
        return False

    @abstractmethod
    def write_a_little(self, connection: Connection) -> None:
        """Write a few bytes that nobody reads, and that reach the disk."""

    @abstractmethod
    def look(self) -> DatabaseObservation:
        """Return who else has written, and what is missing."""

    def changed_since_left(self) -> str | None:
        """Return what is said where the database is not as it was left; takes its time, on any thread."""
        # What a server's files hold only the server knows.
        return None

    @abstractmethod
    def resume(self) -> None:
        """Do what had to wait until it was known whether the database is as it was left."""

    @abstractmethod
    def size_bytes(self) -> int:
        """Return what the database takes; on any thread."""

    @abstractmethod
    def close(self) -> None:
        """Leave everything as it should be left, and let another service have the database."""
