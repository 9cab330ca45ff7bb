"""A database that a demo run left: records of each kind, for tests that look at them.

    python -m tests.helpers.storage.demo_database

makes it anew: 24 calibration and 6 validation configurations on `irb120-clean`, seed 3. Its schema is the one
that the first release begins with: later it is the database from which each migration must lead on.
"""

import asyncio
import lzma
import sqlite3
import tempfile
from pathlib import Path

from truepose.storage.engine.sqlite_connections import LIBRARY

DUMP = Path(__file__).parents[2] / "vectors" / "databases" / "demo.sql.xz"


def write_demo(file: Path) -> None:
    """Write the database to a file that does not exist yet."""
    connection = LIBRARY.connect(file)
    try:
        connection.executescript(lzma.decompress(DUMP.read_bytes()).decode("utf-8"))
    finally:
        connection.close()


def dumped(file: Path) -> bytes:
    """Return a database as `write_demo` takes it."""
    connection = sqlite3.connect(file)
    try:
        return lzma.compress("\n".join(connection.iterdump()).encode(), preset=9)
    finally:
        connection.close()


def main() -> None:
    """Run the demo and keep what it leaves."""
    from truepose.demo.cell_run import CellRequest, run_cell
    from truepose.demo.processes import DATABASE
    from truepose.demo.progress import progress_bar

    with tempfile.TemporaryDirectory(prefix="truepose-") as folder, progress_bar() as progress:
        asyncio.run(run_cell(CellRequest("irb120-clean", 3, 24, 6), Path(folder), progress))
        DUMP.write_bytes(dumped(Path(folder) / DATABASE))


if __name__ == "__main__":
    main()
