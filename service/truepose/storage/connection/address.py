"""From a database URL to the file it names."""

from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import ArgumentError

from truepose.storage.errors import DatabaseAddressError


def database_file(url: str) -> Path:
    """Return the SQLite file that `url` names; raises DatabaseAddressError for anything else.

    Only files: one writer, `synchronous=FULL` and the lock beside the file are promises about a
    disk, which neither another server nor a database in memory can keep.
    """
    try:
        parsed = make_url(url)
    except ArgumentError as error:
        raise DatabaseAddressError(
            f"'{url}' is not a database URL; write sqlite:///folder/file.sqlite3."
        ) from error
    if parsed.get_backend_name() != "sqlite" or parsed.database in {None, "", ":memory:"}:
        raise DatabaseAddressError(
            f"'{parsed.render_as_string()}' is not a SQLite file; write sqlite:///folder/file.sqlite3."
        )
    return Path(str(parsed.database)).expanduser().resolve()
