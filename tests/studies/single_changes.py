"""One value, one row or one order is changed in any table of records; the chain alone must name the place.

`python -m tests.studies.single_changes --out DIR [--runs N] [--seed N]` fills every table that there is, and
changes copies of that database by SQL, as somebody would who can write the file: triggers are put back, the
numbers that were given are set right, and the seal beside the file is gone. A change counts as found only
where `verify` names the first record (or link) that is not as it was.
"""

import contextlib
import math
import random
import shutil
from collections import Counter
from dataclasses import dataclass, field

import sqlalchemy as sa

from tests.helpers.domain.tracker_sessions import make_setup
from tests.studies.running import from_command_line
from truepose.storage.database import Database
from truepose.storage.documents import to_document
from truepose.storage.engine.dialects import Real
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.integrity.verification import verify
from truepose.storage.record_insertion import add_row
from truepose.storage.tables import metadata

_ROWS = 6  # of each table
TABLES = [table for table in metadata.sorted_tables if table.name != "links"]


@dataclass
class Found:
    """What was found, by what was done."""

    runs: int = 0
    found: Counter = field(default_factory=Counter)  # kind of change
    tables: Counter = field(default_factory=Counter)  # whose records were changed
    missed: list = field(default_factory=list)  # of no finding, or of one that names something else


def _value(column, n):
    """Return something that a column can hold; a session's setup is a real one, with its certificates."""
    if column.name == "setup":
        return to_document(make_setup())
    kinds = {
        sa.Integer: n + 1,
        Real: n + 0.5,
        sa.JSON: {"value": n + 0.25, "text": f"of {n}"},
        sa.LargeBinary: bytes([n]) * 9,
    }
    return next((kinds[kind] for kind in kinds if isinstance(column.type, kind)), f"{column.name} {n}")


def _fill(connection):
    for n in range(_ROWS):
        for table in TABLES:
            columns = [column for column in table.columns if column.name not in {"id", "recorded_at"}]
            empty = _empty([column for column in columns if column.nullable], n)
            values = {column.name: _value(column, n) for column in columns if column not in empty}
            add_row(connection, table, **values)


def _empty(nullable, n):
    """Return what a row leaves empty: of what it may refer to all but one, of the rest every other one."""
    referring = [column for column in nullable if column.foreign_keys]
    if len(referring) < 2:
        return nullable[n % 2 :: 2]
    rest = [column for column in nullable if not column.foreign_keys]
    return [
        *(column for column in referring if column is not referring[n % len(referring)]),
        *rest[n % 2 :: 2],
    ]


async def _base(folder):
    database = Database(f"sqlite:///{folder}/base.sqlite3")
    await database.on_writer(lambda connection: connection.execute("PRAGMA foreign_keys = OFF"))
    await database.write(_fill)
    database.close()
    return database.file


# what is done to a copy; each returns the words by which the first bad record must be named, None: draw again


def _record(table, number):
    return f"Record {number} of the {table.replace('_', ' ')}"


def _other(value, rng):
    match value:
        case None:
            return "0"
        case bool() | int():
            return value + rng.choice((-1, 1))
        case float():
            return math.nextafter(value, rng.choice((-1, 1)) * math.inf)
        case bytes():
            at = rng.randrange(len(value))
            return value[:at] + bytes([value[at] ^ 1 << rng.randrange(8)]) + value[at + 1 :]
        case _:
            at = rng.randrange(len(value))
            return value[:at] + chr(ord(value[at]) ^ 1) + value[at + 1 :]


def _some_row(connection, table, rng):
    return rng.choice([n for (n,) in connection.execute(f"SELECT rowid FROM {table}")])


def _value_changed(connection, table, rng):
    row, column = (
        _some_row(connection, table, rng),
        rng.choice([c.name for c in metadata.tables[table].columns]),
    )
    if column == "id":
        return None
    value = connection.execute(f"SELECT {column} FROM {table} WHERE rowid = ?", (row,)).fetchone()[0]
    if value == "" or value == b"":
        return None
    connection.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (_other(value, rng), row))
    return _record(table, row)


def _deleted(connection, table, rng):
    row = _some_row(connection, table, rng)
    connection.execute(f"DELETE FROM {table} WHERE rowid = ?", (row,))
    return _record(table, row)


def _exchanged(connection, table, rng):
    one, two = sorted((_some_row(connection, table, rng), _some_row(connection, table, rng)))
    if one == two:
        return None
    for old, new in ((one, -1), (two, one), (-1, two)):
        connection.execute(f"UPDATE {table} SET rowid = ? WHERE rowid = ?", (new, old))
    return _record(table, one)


def _doubled(connection, table, rng):
    names = ", ".join(c.name for c in metadata.tables[table].columns if c.name != "id")
    row = _some_row(connection, table, rng)
    connection.execute(f"INSERT INTO {table} ({names}) SELECT {names} FROM {table} WHERE rowid = ?", (row,))
    return _record(table, connection.execute("SELECT last_insert_rowid()").fetchone()[0])


def _link_changed(connection, _table, rng):
    number = _some_row(connection, "links", rng)
    record, row, found = connection.execute(
        "SELECT record, record_id, hash FROM links WHERE id = ?", (number,)
    ).fetchone()
    connection.execute("UPDATE links SET hash = ? WHERE id = ?", (_other(found, rng), number))
    return _record(record, row)


def _link_deleted(connection, _table, rng):
    number = _some_row(connection, "links", rng)
    if number == len(TABLES) * _ROWS:  # the newest one: its record is there without a link
        record, row = connection.execute(
            "SELECT record, record_id FROM links WHERE id = ?", (number,)
        ).fetchone()
    connection.execute("DELETE FROM links WHERE id = ?", (number,))
    return (
        _record(record, row) if number == len(TABLES) * _ROWS else f"Links {number} to {number} of the chain"
    )


KINDS = {
    "a value": _value_changed,
    "a record taken out": _deleted,
    "two records exchanged": _exchanged,
    "a record slipped in": _doubled,
    "a link's hash": _link_changed,
    "a link taken out": _link_deleted,
}


def _changed(file, kind, table, rng):
    """Change a database and return how the place must be named; None where that could not be done."""
    with contextlib.closing(LIBRARY.connect(file)) as connection:
        protection = [
            (name, sql)
            for name, sql in connection.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger'")
            if name.startswith((f"{table}_no_", "links_no_"))
        ]
        for name, _ in protection:
            connection.execute(f"DROP TRIGGER {name}")
        connection.execute("PRAGMA foreign_keys = OFF")
        connection.execute("PRAGMA synchronous = OFF")
        try:
            named = KINDS[kind](connection, table, rng)
        except LIBRARY.IntegrityError:
            return None
        for _, sql in protection:
            connection.execute(sql)
        if table != "request_keys":
            newest = f"SELECT coalesce(max(id), 0) FROM {table}"
            connection.execute(f"UPDATE sqlite_sequence SET seq = ({newest}) WHERE name = '{table}'")
        connection.execute(
            "UPDATE sqlite_sequence SET seq = (SELECT max(id) FROM links) WHERE name = 'links'"
        )
        connection.commit()
        return named


async def single_changes(folder, runs, seed):
    """Change one thing so often and return what was found."""
    base, rng, tally = await _base(folder), random.Random(seed), Found()
    file = folder / "changed.sqlite3"
    while tally.runs < runs:
        kind = [*KINDS][tally.runs % len(KINDS)]
        table = rng.choice(TABLES).name
        shutil.copy(base, file)
        named = _changed(file, kind, table, rng)
        if named is None:
            continue
        findings = verify(file).findings
        tally.runs += 1
        tally.tables["links" if "link" in kind else table] += 1
        if findings and named in findings[0]:
            tally.found[kind] += 1
        else:
            tally.missed.append((kind, table, named, findings[:1]))
    return tally


def told(tally):
    """Return what was found, in words."""
    lines = "".join(f"{kind}: {tally.found[kind]} found\n" for kind in KINDS)
    return lines + (
        f"{tally.runs} single changes in {len(tally.tables)} tables: {sum(tally.found.values())} found and "
        f"the first bad record named, {len(tally.missed)} not {tally.missed[:5] or ''}\n"
    )


if __name__ == "__main__":
    from_command_line(__doc__, "single_changes", single_changes, told, runs=10_000, seed=1)
