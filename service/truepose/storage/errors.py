"""Errors of the storage; each text is one sentence for whoever runs the service.

StorageError
├── DatabaseAddressError     the URL names something that cannot be a database of this service
├── DatabaseInUseError       another service holds the same database
├── NewerSchemaError         the database was written by a newer version
├── ForeignDatabaseError     the file is no database, or another program's
├── ChainHeadError           what was typed is no head of a chain
├── UnreadableRowError       what came as a record of a cell is none
├── TamperedRecordError      a record of a cell is not the one of its link, or did not come
├── AnotherChainError        a cell shows another chain than the one collected from it
├── BackupError              a copy cannot be written, or is not one
│   └── DatabaseUsedError      a database with records lies where a copy is to be restored
├── StorageUnavailableError  the disk refused (full, locked, read-only, gone); also a RecordRefusedError
│   ├── DamagedDatabaseError   what is on disk is not what was written
│   ├── ServerAwayError        the server of the database does not answer
│   └── ServerRefusedError     it answers, and refuses
├── NotFoundError            no record of that number
│   └── NotInPlantError        no cell of that name, or nothing of that serial number
└── ConflictError            the record does not allow that now
    ├── CollectedMeanwhileError  links of a cell that were collected already
    ├── KeyReusedError         an Idempotency-Key came back with another request
    └── UnfitReadingError      a delivered reading is not what its series is of
"""

from truepose.domain.errors import RecordRefusedError, TrueposeError
from truepose.messages.message import Text, message


class StorageError(TrueposeError):
    """Base of every error of the storage."""


class DatabaseAddressError(StorageError):
    """The URL names something that cannot be a database of this service."""


class DatabaseInUseError(StorageError):
    """Another service holds the same database."""


class NewerSchemaError(StorageError):
    """The database was written by a newer version of the program."""


class ForeignDatabaseError(StorageError):
    """The file is no SQLite database, or it belongs to another program."""


class ChainHeadError(StorageError):
    """What somebody typed off a report is no head of a chain."""


class UnreadableRowError(StorageError):
    """What came as a record of a cell is none."""


class TamperedRecordError(StorageError):
    """A record of a cell is not the one that its link was made of, or did not come with it."""


class AnotherChainError(StorageError):
    """A cell shows another chain than the one that was collected from it."""


class BackupError(StorageError):
    """A copy of a database cannot be written, or what was named is no whole one."""


class DatabaseUsedError(BackupError):
    """A database with records lies where a copy is to be restored."""


# Also the domain's own word, which is what sessions wait for: they know nothing of a storage.
class StorageUnavailableError(StorageError, RecordRefusedError):
    """The disk refused to read or write; nothing of that request was kept."""


class DamagedDatabaseError(StorageUnavailableError):
    """What is on disk is not what was written; nothing of it is used."""


class ServerAwayError(StorageUnavailableError):
    """The server of the database does not answer; nothing of that request was kept."""


class ServerRefusedError(StorageUnavailableError):
    """The server of the database refused, for want of room, rights, connections; nothing was kept."""


def damaged(where: str, said: str) -> DamagedDatabaseError:
    """Return the error of a database that does not hold what was written."""
    return DamagedDatabaseError(
        f"The database {where} is damaged ({said}); stop the service, keep the file, and restore the last"
        " backup."
    )


class NotFoundError(StorageError):
    """There is no record of that number."""

    def __init__(self, what: str, number: int) -> None:
        super().__init__(message("refused.no_record", what=what, number=number))


class NotInPlantError(NotFoundError):
    """There is no cell of that name in a plant, or nothing of that serial number was measured there."""

    def __init__(self, sentence: Text) -> None:
        StorageError.__init__(self, sentence)


class ConflictError(StorageError):
    """The record does not allow that in its present state."""


class CollectedMeanwhileError(ConflictError):
    """Links of a cell do not follow what is collected by now: somebody has collected meanwhile."""


class KeyReusedError(ConflictError):
    """An Idempotency-Key was sent before with a different request."""


class UnfitReadingError(ConflictError):
    """A reading that a program delivers is not what its series is of."""
