"""Brings a database to the newest schema, and refuses one that is newer or somebody else's."""

from functools import cache
from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, inspect

from truepose.storage import migrations
from truepose.storage.errors import ForeignDatabaseError, NewerSchemaError


def migration_config() -> Config:
    """Return alembic's settings, with the folder of the migrations."""
    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent).replace("%", "%%"))
    return config


@cache
def _script() -> ScriptDirectory:
    return ScriptDirectory.from_config(migration_config())


def newest_revision() -> str:
    """Return the schema that this version of the program writes."""
    return str(_script().get_current_head())


def bring_up_to_date(connection: Connection, where: str) -> str:
    """Run what migrations are missing and return the schema; the caller commits.

    Raises
    ------
    NewerSchemaError
        The database has a schema that this version does not know.
    ForeignDatabaseError
        The database holds tables of another program.
    """
    current = MigrationContext.configure(connection).get_current_revision()
    if current == newest_revision():
        return current
    known = {revision.revision for revision in _script().walk_revisions()}
    if current is None and inspect(connection).get_table_names():
        raise ForeignDatabaseError(f"{where} holds another program's tables; choose another file.")
    if current is not None and current not in known:
        raise NewerSchemaError(
            f"{where} has schema {current}, this version of truepose knows up to {newest_revision()}; "
            "start the newer version that wrote it, or choose another file."
        )
    config = migration_config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
    return newest_revision()
