"""Databases that earlier programs of this project left, one of each schema that was ever in use.

Each is what that program had on disk after a demo run of 24 calibration and 6 validation configurations on
`irb120-clean`, seed 3: sessions, readings, a campaign, identification, validation and, from schema 0005 on,
a diagnosis. `python -m tests.studies.left_database` writes that of the present schema: before a migration
is added, its file is added here.
"""

import lzma
from importlib import resources
from pathlib import Path

from truepose.storage.connection.sqlite.library import LIBRARY

_PREFIX, _SUFFIX = "schema_", ".sql.xz"


def earlier_schemas() -> tuple[str, ...]:
    """Return the revisions of which a database is kept, the oldest first."""
    names = (file.name for file in resources.files(__name__).iterdir())
    found = (name.removeprefix(_PREFIX).removesuffix(_SUFFIX) for name in names if name.endswith(_SUFFIX))
    return tuple(sorted(found))


def write_earlier(schema: str, file: Path) -> None:
    """Write the database of a schema to a file that does not exist yet; raises OSError."""
    packed = resources.files(__name__).joinpath(f"{_PREFIX}{schema}{_SUFFIX}").read_bytes()
    connection = LIBRARY.connect(file)
    try:
        connection.executescript(lzma.decompress(packed).decode("utf-8"))
    finally:
        connection.close()
