"""Runs the migrations on the connection that the caller passes in `config.attributes["connection"]`.

There is no ini file: the service passes its own writer connection. From the alembic command line
(`alembic upgrade head`, for whoever writes a migration) the URL comes from `-x url=sqlite:///...`.
"""

from alembic import context
from sqlalchemy import Connection, create_engine

from truepose.storage.tables import metadata


def _migrate(connection: Connection) -> None:
    # Batch mode: SQLite alters little in place, later migrations rebuild tables.
    context.configure(connection=connection, target_metadata=metadata, render_as_batch=True)
    with context.begin_transaction():
        context.run_migrations()


def _url() -> str:
    url = context.get_x_argument(as_dictionary=True).get("url")
    if not url:
        raise SystemExit("Say which database: alembic -x url=sqlite:///truepose.sqlite3 ...")
    return url


passed = context.config.attributes.get("connection")
if passed is None:
    with create_engine(_url()).connect() as opened:
        _migrate(opened)
        opened.commit()
else:
    _migrate(passed)
