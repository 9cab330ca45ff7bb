"""Writes the statements of the first schema, for each engine, from the tables of the storage.

    python -m tests.studies.baseline migrations/versions

Until the first release; then that schema stays as it is, and a migration follows it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from sqlalchemy import Dialect
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.schema import CreateIndex, CreateTable

from truepose.storage.tables import metadata

DIALECTS: dict[str, Dialect] = {"sqlite": sqlite.dialect(), "postgresql": postgresql.dialect()}


def statements(dialect: Dialect) -> str:
    """Return what makes all tables with their indices, a statement after the other."""
    return ";\n".join(_each(dialect)) + "\n"


def _each(dialect: Dialect) -> Iterator[str]:
    for table in metadata.sorted_tables:
        made = str(CreateTable(table).compile(dialect=dialect))
        yield "\n".join(line.rstrip() for line in made.strip().splitlines())
        for index in sorted(table.indexes, key=lambda one: str(one.name)):
            yield str(CreateIndex(index).compile(dialect=dialect)).strip()


if __name__ == "__main__":
    for name, dialect in DIALECTS.items():
        (Path(sys.argv[1]) / f"0001_{name}.sql").write_text(statements(dialect), encoding="utf-8")
