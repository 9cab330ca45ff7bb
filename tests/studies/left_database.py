"""Writes the database that this program leaves, for `truepose.demo.night.earlier`.

    python -m tests.studies.left_database service/truepose/demo/night/earlier

To be run before a migration is added: afterwards nobody leaves such a database any more.
"""

import argparse
import asyncio
import lzma
import sqlite3
import tempfile
from collections.abc import Sequence
from pathlib import Path

from truepose.demo.cell.opened import DATABASE
from truepose.demo.cell.run import CellRequest, run_cell
from truepose.demo.progress import shown_progress


def dumped(file: Path) -> tuple[str, str]:
    """Return the schema of a database, and its dump."""
    connection = sqlite3.connect(file)
    try:
        ((schema,),) = connection.execute("SELECT version_num FROM alembic_version").fetchall()
        return str(schema), "\n".join(connection.iterdump())
    finally:
        connection.close()


def main(arguments: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    wanted = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="truepose-") as temporary, shown_progress() as progress:
        asyncio.run(run_cell(CellRequest("irb120-clean", 3, 24, 6), Path(temporary), progress))
        schema, dump = dumped(Path(temporary) / DATABASE)
    (wanted.folder / f"schema_{schema}.sql.xz").write_bytes(lzma.compress(dump.encode(), preset=9))


if __name__ == "__main__":
    main()
