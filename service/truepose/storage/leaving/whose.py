"""Whether a database is a cell's or a plant's: what lies in one chain can never be parted again."""

from typing import Final

from sqlalchemy import Connection, select

from truepose.storage.database import Database
from truepose.storage.errors import ForeignDatabaseError
from truepose.storage.tables import metadata

_OF_CELLS: Final = ("sessions", "campaigns", "series")
_OF_PLANTS: Final = ("plant_cells",)


async def require_of_cell(database: Database) -> None:
    """Raise ForeignDatabaseError for a database with a plant's records and none of a cell."""
    if await database.read(lambda c: _has(c, _OF_PLANTS) and not _has(c, _OF_CELLS)):
        raise ForeignDatabaseError(
            f"{database.held.where} is the database of a plant; start it with 'truepose plant', or choose "
            "another with --database."
        )


async def require_of_plant(database: Database) -> None:
    """Raise ForeignDatabaseError for a database with a cell's records and none of a plant."""
    if await database.read(lambda c: _has(c, _OF_CELLS) and not _has(c, _OF_PLANTS)):
        raise ForeignDatabaseError(
            f"{database.held.where} is the database of a cell, and a plant has one of its own: choose "
            "another with --database."
        )


def _has(connection: Connection, records: tuple[str, ...]) -> bool:
    return any(
        connection.execute(select(metadata.tables[table].c.id).limit(1)).one_or_none() is not None
        for table in records
    )
