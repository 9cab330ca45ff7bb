"""What a database of either kind is to the service that holds it: the seam between storage and engines.

Each engine has a room beside this file (`sqlite`, `postgresql`). Nobody else asks which of them it is.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Connection, Engine
from sqlalchemy.engine import Transaction

from truepose.storage.errors import StorageError
from truepose.storage.integrity.condition import Condition
from truepose.storage.integrity.seal import Left

READERS: Final = 4  # as many queries at a time as a handful of browsers asks for
Alone = Callable[[], AbstractContextManager[None]]  # while it lasts nobody reads


class InDoubtError(Exception):
    """The connection ended during a commit: whether the server has made it shows when it is back."""

    def __init__(self, newest: Left) -> None:
        super().__init__("The connection ended during a commit.")
        self.newest = newest  # link, which the database has then and only then


@dataclass(frozen=True, slots=True)
class Seen:
    """What a look at the open database finds."""

    foreign: bool  # somebody else has written since the last look
    missing: tuple[str, ...]  # of its protection


class Holding(ABC):
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
    def commit(self, transaction: Transaction, newest: Left) -> None:
        """Commit and note the newest link; raises InDoubtError and what the library raises."""

    @abstractmethod
    def has(self, newest: Left) -> bool:
        """Whether the database has a link."""

    @property
    @abstractmethod
    def plain(self) -> Any:
        """The connection that writes as the library has it (`connection.plain`), outside transactions."""

    @abstractmethod
    def translated(self, error: Exception) -> StorageError:
        """Return what the library raised as an error of the storage; on any thread."""

    @abstractmethod
    def ended(self, error: Exception) -> bool:
        """Whether what the library raised says that a connection has ended; on any thread."""

    @abstractmethod
    def make_room(self, error: Exception) -> bool:
        """Give up the reserve where the library found no room; returns whether there was any."""

    @abstractmethod
    def keep_reserve(self) -> None:
        """Take the reserve back once there is room."""

    @property
    @abstractmethod
    def reserve_used(self) -> bool:
        """Whether the reserve is given up; on any thread."""

    @abstractmethod
    def write_a_little(self, connection: Connection) -> None:
        """Write a few bytes that nobody reads, and that reach the disk."""

    @abstractmethod
    def look(self) -> Seen:
        """Return who else has written, and what is missing."""

    @abstractmethod
    def changed_since_left(self) -> str | None:
        """Return what is said where the database is not as it was left; takes its time, on any thread."""

    @abstractmethod
    def resume(self) -> None:
        """Do what had to wait until it was known whether the database is as it was left."""

    @abstractmethod
    def size_bytes(self) -> int:
        """Return what the database takes; on any thread."""

    @abstractmethod
    def close(self) -> None:
        """Leave everything as it should be left, and let another service have the database."""
