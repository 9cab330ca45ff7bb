"""A database of a server that this service holds, by the lock that the connection has which writes.

There is no reserve and no seal over a file: the disk is the server's. What stays is the newest link, noted on
this machine after each commit, so that a server which comes back with less than it acknowledged is found out.
"""

import contextlib
import logging
from typing import Any, Final

from sqlalchemy import Connection
from sqlalchemy.engine import Transaction
from sqlalchemy.exc import DBAPIError

from truepose.storage.engine.address import database_file, display_url, parsed_url
from truepose.storage.engine.backend import (
    READERS,
    Alone,
    Condition,
    DatabaseBackend,
    DatabaseObservation,
    InDoubtError,
)
from truepose.storage.engine.postgresql_connections import (
    ACCEPTED,
    REFUSED,
    PlainConnection,
    has_ended,
    reading_engine,
    translate_error,
    writing_engine,
)
from truepose.storage.engine.postgresql_server import (
    doubts,
    require_durable,
    require_fit,
    require_writable,
    server_file,
    settings_of,
    take_lock,
)
from truepose.storage.engine.raw_connection import missing_protection
from truepose.storage.engine.schema import bring_up_to_date
from truepose.storage.errors import DatabaseInUseError, ServerRefusedError, StorageError
from truepose.storage.integrity.database_identity import ClosingState, IdentityFile, has_link, newest_link
from truepose.storage.integrity.verification import newest_missing

_LOG: Final = logging.getLogger(__name__)
_SIZE: Final = "SELECT pg_database_size(current_database())"
_A_LITTLE: Final = "SELECT pg_logical_emit_message(true, 'truepose', '')"  # to the log, as a commit does


class ServerDatabase(DatabaseBackend):
    """Readers see one moment each (repeatable read); a commit returns when the server has it on its disk."""

    refused = REFUSED

    def __init__(self, url: str, condition: Condition, alone: Alone) -> None:
        self._url = parsed_url(url)
        super().__init__(url, database_file(url), display_url(self._url), condition, alone)
        self._doubtful: ClosingState | None = None  # newest link of a commit that may have been made
        self._lost: str | None = None  # why nothing is written any more
        self._was_away = False  # and nobody has looked yet what was written meanwhile
        self._size_bytes = 0

    def open(self) -> str:
        """Take the lock, open everything, bring the schema up to date and return it; raises StorageError."""
        self._write_engine = writing_engine(self._url)
        self.readers = reading_engine(self._url, READERS)
        try:
            return self._open()
        except REFUSED as error:
            self._write_engine.dispose()
            raise self.translated(error) from error
        except BaseException:
            self._write_engine.dispose()
            raise

    def _open(self) -> str:
        self._connect(patient=True)
        try:
            left = self._left()
            # Before the first write of this service: a server that loses what it has acknowledged is refused.
            self.server_doubts = self._durability()
            with self.connection.begin():
                schema = bring_up_to_date(self.connection, self.where)
            for finding in missing_protection(self.plain):
                self.condition.note_damage(finding, finding)
            # The server may have been put back to an earlier moment, by a dump or a snapshot of its disk.
            if left is not None and not has_link(self.plain, left):
                self.condition.note_damage("newest", newest_missing(self.where, self._seal.file))
            self._seal.break_open(self.plain)
        except BaseException:
            self.connection.close()
            raise
        return schema

    def _left(self) -> ClosingState | None:
        """Find what lies on this machine, and return how the database was left."""
        # Asked of the server, over the connection that has the lock: only then is it certain which database
        # this is (decision 0068).
        self.file = server_file(self.plain, self.where)
        self.file.parent.mkdir(parents=True, exist_ok=True)
        _LOG.info("%s: what lies on this machine begins with %s", self.where, self.file)
        self._seal = IdentityFile(self.file)
        return self._seal.left()

    def _durability(self) -> tuple[str, ...]:
        settings = settings_of(self.plain)
        require_durable(self.where, settings, accepted=self._url.query.get(ACCEPTED) == "off")
        found = doubts(settings)
        _LOG.info("%s: off on the server: %s", self.where, ", ".join(found) or "nothing that matters")
        return found

    def _connect(self, *, patient: bool) -> None:
        self.connection = self._write_engine.connect()
        try:
            require_fit(self.plain, self.where)
            # The lock before anything else is read or written. At the start it is waited for a little, as the
            # server may not have noticed yet that the service before was killed; within a run others wait
            # meanwhile, and try again.
            take_lock(self.plain, self.where, *(() if patient else (0.0,)))
            require_writable(self.plain, self.where)
        except BaseException:
            self.connection.close()
            raise

    def make_ready(self) -> None:
        """Connect anew where the connection has ended, if nobody else has the database."""
        # For good: what this service remembers of the chain is no longer what the database holds. A person
        # starts it anew.
        if self._lost is not None:
            raise ServerRefusedError(self._lost)
        if not self._disconnected:
            return
        self._let_go()
        try:
            self._connect(patient=False)
        except DatabaseInUseError as error:  # or the server has not yet noticed that ours has ended
            raise ServerRefusedError(str(error)) from error
        self._was_away = True
        _LOG.warning("connected to %s anew", self.where)

    @property
    def _disconnected(self) -> bool:
        return self.connection.closed or self.connection.invalidated or bool(self.plain.server.closed)

    def _let_go(self) -> None:
        if not self.connection.closed:
            # The connection has ended already, as a rule; closing it must not hide why.
            with contextlib.suppress(*REFUSED):
                self.connection.invalidate()
            self.connection.close()

    def require_ours(self) -> None:
        """Raise ServerRefusedError where the newest link is not the last one that was written here."""
        if not self._was_away:
            return
        newest = newest_link(self.plain)
        # Two links are right: the last one that was acknowledged, and the one of the commit in doubt.
        if newest not in (self._seal.noted, self._doubtful):
            self._lost = (
                f"While the connection was away, {self.where} was written by another service or restored to "
                "an earlier state; restart this service."
            )
            self.connection.close()
            raise ServerRefusedError(self._lost)
        self._was_away, self._doubtful = False, None
        self._seal.note(newest)

    def commit(self, transaction: Transaction, newest: ClosingState) -> None:
        """Commit and note the newest link; raises InDoubtError and what the library raises."""
        try:
            transaction.commit()
        except DBAPIError as error:
            if not has_ended(error):
                raise
            # Kept for the next connection: the newest link that it finds may be this one, which is ours as
            # well.
            self._doubtful = newest
            raise InDoubtError(newest) from error
        self._seal.note(newest)

    @property
    def plain(self) -> Any:
        """The library's own connection, for what is done outside transactions."""
        return PlainConnection(self.connection.connection.dbapi_connection)  # type: ignore[arg-type]

    def translated(self, error: Exception) -> StorageError:
        """Return what the library raised as an error of the storage."""
        return translate_error(self.where, error)

    def ended(self, error: Exception) -> bool:
        """Whether what the library raised says that a connection has ended."""
        return has_ended(error)

    def keep_reserve(self) -> None:
        """Do nothing: the disk is the server's."""

    def write_a_little(self, connection: Connection) -> None:
        """Write to the server's log, for which a commit waits; raises ServerRefusedError."""
        # A server that became a standby takes the message below and writes nothing.
        require_writable(self.plain, self.where)
        connection.exec_driver_sql(_A_LITTLE)

    def look(self) -> DatabaseObservation:
        """Return whether the newest link is another than was written here, and what is missing."""
        newest, before = newest_link(self.plain), self._seal.noted
        # Otherwise the same foreign link would be found again at every look.
        self._seal.note(newest)
        self._size_bytes = int(self.plain.execute(_SIZE).fetchone()[0])
        return DatabaseObservation(newest != before, tuple(missing_protection(self.plain)))

    def resume(self) -> None:
        """Do nothing: nothing has waited."""

    def size_bytes(self) -> int:
        """Return what the database took at the last look."""
        return self._size_bytes

    def close(self) -> None:
        """End the connections, and with them the lock."""
        # Also of records that came past `commit`, as a copy's do; after a lost connection somebody else's may
        # have come.
        if not (self._disconnected or self._was_away):
            with contextlib.suppress(*REFUSED):
                self._seal.note(newest_link(self.plain))
        self.readers.dispose()
        self._let_go()
        self._write_engine.dispose()
        # There is no file whose digest could be taken: the server's disk is the server's.
        self._seal.close(None)
