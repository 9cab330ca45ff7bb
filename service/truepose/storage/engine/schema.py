"""Brings a database to the newest schema, and refuses one that is newer or somebody else's."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection, inspect, text

from truepose.storage import migrations
from truepose.storage.errors import ForeignDatabaseError, NewerSchemaError

if TYPE_CHECKING:
    from alembic.config import Config


@cache
def revisions() -> tuple[str, ...]:
    """Return every schema that this version of the program knows, the newest last, by the names of files."""
    files = (Path(migrations.__file__).parent / "versions").glob("[0-9]*.py")
    return tuple(sorted(file.name.split("_")[0] for file in files))


def newest_revision() -> str:
    """Return the schema that this version of the program writes."""
    return revisions()[-1]


def bring_up_to_date(connection: Connection, where: str) -> str:
    """Run what migrations are missing and return the schema; the caller commits.

    Raises
    ------
    NewerSchemaError
        The database has a schema that this version does not know.
    ForeignDatabaseError
        The database holds tables of another program.
    """
    tables = inspect(connection).get_table_names()
    marked = "alembic_version" in tables
    current: str | None = (
        connection.scalar(text("SELECT version_num FROM alembic_version")) if marked else None
    )
    # Without alembic, whose import alone is a tenth of a start.
    if current == newest_revision():
        return current
    # An empty database has no revision and no tables; tables without a revision are somebody else's, and
    # migrations would write between them.
    if current is None and [table for table in tables if table != "alembic_version"]:
        raise ForeignDatabaseError(f"{where} holds another program's tables; choose another file.")
    if current is not None and current not in revisions():
        raise NewerSchemaError(
            f"{where} has schema {current}, this version of truepose knows up to {newest_revision()}; "
            "start the version that wrote it, or choose another file."
        )
    upgrade(connection)
    return newest_revision()


def upgrade(connection: Connection) -> None:
    """Run every migration that the database does not have yet."""
    # A tenth of the start of a service, which finds its database as it left it.
    from alembic import command

    config = migration_config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def migration_config() -> "Config":
    """Return alembic's settings, with the folder of the migrations."""
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent).replace("%", "%%"))
    return config
