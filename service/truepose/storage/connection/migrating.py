"""Runs migrations; imported where there are any to run."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection

from truepose.storage import migrations


def migration_config() -> Config:
    """Return alembic's settings, with the folder of the migrations."""
    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent).replace("%", "%%"))
    return config


def upgrade(connection: Connection) -> None:
    """Run every migration that the database does not have yet."""
    config = migration_config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
