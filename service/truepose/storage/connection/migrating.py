"""Runs migrations; imported where there are any to run."""

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection

from truepose.storage.connection.schema import MIGRATIONS


def migration_config() -> Config:
    """Return alembic's settings, with the folder of the migrations."""
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    return config


def upgrade(connection: Connection) -> None:
    """Run every migration that the database does not have yet."""
    config = migration_config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
