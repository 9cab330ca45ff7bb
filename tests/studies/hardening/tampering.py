"""A database is tampered with in many ways; each must be noticed at the start of a service or by `verify`.

`python -m tests.studies.hardening.tampering --out DIR [--runs N] [--seed N]` takes copies of two databases:
one that a service closed in order, with its seal, and one whose service was killed, with its log. A change
that is not noticed is counted as harmless only where every record, link and trigger reads as before.
"""

import asyncio
import contextlib
import os
import random
import shutil
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.helpers.ballbar.sessions import make_ballbar_plan, measured
from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.studies.running import from_command_line
from truepose.storage.database import Database
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import StorageError
from truepose.storage.integrity.monitor import Guard
from truepose.storage.integrity.verification import verify_left
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.tables import metadata

_ENOUGH = 100_000  # rows: pages that point at each other have no end
_PARTS = ("", "-wal", ".seal")
_TABLES = ("readings", "events", "session_states", "session_entries", "links", "sessions")


@dataclass
class Tally:
    """What was noticed, and by what."""

    runs: int = 0
    noticed: Counter = field(default_factory=Counter)  # by kind
    by: Counter = field(default_factory=Counter)  # refused at start, said at start, verify
    harmless: Counter = field(default_factory=Counter)  # nothing reads otherwise
    missed: list = field(default_factory=list)  # kinds


async def _fill(database):
    sessions = SessionRepository(database)
    number = await sessions.add("tracker", make_setup(), make_plan())
    ledger = LedgerRepository(database)
    await asyncio.gather(*(ledger.append(number, point_taken(make_point(k))) for k in range(150)))
    ballbar = await sessions.add("ballbar", make_setup(), make_ballbar_plan())
    for leg in range(1, 7):
        await ledger.append(ballbar, measured(f"placement-1/pose-{leg}/leg-1-1"))


async def _bases(folder):
    """Make the database that was closed in order, the one whose service was killed, and another one."""
    for name in ("closed", "other"):
        database = Database(f"sqlite:///{folder}/{name}")
        await _fill(database)
        if name == "closed":
            for part in _PARTS:
                shutil.copy(f"{database.file}{part}", folder / f"killed{part}")
        database.close()


# what is done to a copy; each returns what it did


def _flip(file, rng):
    content = bytearray(file.read_bytes())
    at = rng.randrange(len(content))
    content[at] ^= 1 << rng.randrange(8)
    file.write_bytes(content)


def _zero(file, rng):
    content = bytearray(file.read_bytes())
    at = rng.randrange(0, len(content), 4096)
    content[at : at + 4096] = bytes(4096)
    file.write_bytes(content[: file.stat().st_size])


def _cut(file, rng):
    os.truncate(file, rng.randrange(file.stat().st_size))


def _exchange_pages(file, rng):
    content = bytearray(file.read_bytes())
    one, two = rng.sample(range(1, len(content) // 4096), 2)
    a, b = slice(4096 * one, 4096 * one + 4096), slice(4096 * two, 4096 * two + 4096)
    content[a], content[b] = content[b], content[a]
    file.write_bytes(content)


def _page_of_another(file, rng):
    content, other = bytearray(file.read_bytes()), file.with_name("other").read_bytes()
    at = 4096 * rng.randrange(1, min(len(content), len(other)) // 4096)
    content[at : at + 4096] = other[at : at + 4096]
    file.write_bytes(content)


def _put_another(file, rng):
    shutil.copy(file.with_name("other"), file)


def _log_removed(file, rng):
    Path(f"{file}-wal").unlink()


def _log_cut(file, rng):
    _cut(Path(f"{file}-wal"), rng)


def _log_flipped(file, rng):
    _flip(Path(f"{file}-wal"), rng)


def _sql(change, *tables):
    def done(file, rng):
        table = rng.choice(tables or _TABLES)
        with contextlib.closing(LIBRARY.connect(file)) as connection:
            # Most rows: a row is needed, so that something is changed.
            rows = [n for (n,) in connection.execute(f"SELECT rowid FROM {table} ORDER BY rowid")]
            triggers = [
                connection.execute("SELECT sql FROM sqlite_schema WHERE name = ?", (f"{table}_no_{action}",))
                .fetchone()[0]
                for action in ("update", "delete")
            ]  # fmt: skip
            for action in ("update", "delete"):
                connection.execute(f"DROP TRIGGER {table}_no_{action}")
            connection.execute("PRAGMA foreign_keys = OFF")
            change(connection, table, rows, rng)
            for trigger in triggers:
                connection.execute(trigger)
            connection.commit()

    return done


def _longer(connection, table, rows, rng):
    longer = "UPDATE readings SET document = json_set(document, '$.position_world_mm[0]', 102.0) WHERE id = ?"
    connection.execute(longer, (rng.randrange(1, 151),))


def _deleted(connection, table, rows, rng):
    connection.execute(f"DELETE FROM {table} WHERE rowid = ?", (rng.choice(rows),))


def _newest_deleted(connection, table, rows, rng):
    connection.execute(f"DELETE FROM {table} WHERE rowid >= ?", (rows[-rng.randrange(1, 3)],))


def _column_changed(connection, table, rows, rng):
    columns = [c[1] for c in connection.execute(f"PRAGMA table_info({table})") if c[1] != "id"]
    column, row = rng.choice(columns), rng.choice(rows)
    other = f"coalesce({column} || '1', '1')"
    connection.execute(f"UPDATE OR REPLACE {table} SET {column} = {other} WHERE rowid = ?", (row,))


def _exchanged(connection, table, rows, rng):
    one, two = rng.sample(rows, 2)
    for old, new in ((one, -1), (two, one), (-1, two)):
        connection.execute(f"UPDATE {table} SET id = ? WHERE id = ?", (new, old))


def _slipped_in(connection, table, rows, rng):
    columns = [
        c[1]
        for c in connection.execute(f"PRAGMA table_info({table})")
        if c[1] not in {"id", "key", "supersedes"}
    ]
    names = ", ".join(columns)
    connection.execute(
        f"INSERT INTO {table} ({names}) SELECT {names} FROM {table} WHERE rowid = ?", (rng.choice(rows),)
    )


def _replaced(file, rng):
    with contextlib.closing(LIBRARY.connect(file)) as connection:
        connection.execute("PRAGMA recursive_triggers = OFF")
        connection.execute(
            "INSERT OR REPLACE INTO readings SELECT id, recorded_at, session_id, kind, config, nest, time_s, "
            "supersedes, replace(document, '101.0', '102.0') FROM readings WHERE id = ?",
            (rng.randrange(1, 151),),
        )
        connection.commit()


def _trigger_dropped(file, rng):
    with contextlib.closing(LIBRARY.connect(file)) as connection:
        connection.execute(
            f"DROP TRIGGER {rng.choice([*metadata.tables])}_no_{rng.choice(['update', 'delete'])}"
        )
        connection.commit()


KINDS = {
    "a bit of the file": ("closed", _flip),
    "a bit of the file, killed": ("killed", _flip),
    "a page of zeros": ("closed", _zero),
    "a page of zeros, killed": ("killed", _zero),
    "the file cut": ("closed", _cut),
    "two pages exchanged": ("closed", _exchange_pages),
    "a page of another database": ("closed", _page_of_another),
    "another database in its place": ("closed", _put_another),
    "the log removed": ("killed", _log_removed),
    "the log cut": ("killed", _log_cut),
    "a bit of the log": ("killed", _log_flipped),
    "a reading 1 mm longer": ("killed", _sql(_longer, "readings")),
    "a record deleted": ("killed", _sql(_deleted)),
    "the newest records deleted": ("killed", _sql(_newest_deleted)),
    "a column changed": ("killed", _sql(_column_changed)),
    "two records exchanged": ("killed", _sql(_exchanged)),
    "a record slipped in": ("killed", _sql(_slipped_in)),
    "a reading replaced": ("killed", _replaced),
    "a trigger dropped": ("killed", _trigger_dropped),
}


def _read(file):
    """Return everything that a database says, None where it cannot be read."""
    try:
        with contextlib.closing(LIBRARY.connect(f"file:{file}?mode=ro", uri=True)) as connection:
            connection.text_factory = bytes
            names = [
                bytes(n).decode()
                for (n,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")
            ]
            said = {name: connection.execute(f'SELECT * FROM "{name}"').fetchmany(_ENOUGH) for name in names}
            return said, connection.execute("SELECT * FROM sqlite_schema").fetchall()
    except (LIBRARY.DatabaseError, UnicodeDecodeError):
        return None


async def _noticed(file):
    """Return by what the change is noticed, None where by nothing."""
    by_verify = bool(verify_left(file).findings)
    try:
        database = await asyncio.to_thread(Database, f"sqlite:///{file}")
    except StorageError:
        return "refused at the start"
    try:
        if database.condition.fault is not None:
            return "said at the start"
        if by_verify:
            return "verify, also after each start"
        await Guard(database, 0.0).check_seal()
        return "seal, after the start" if database.condition.fault else None
    finally:
        database.close()


async def tampering(folder, runs, seed):
    """Tamper so often and return what was noticed."""
    rng, tally = random.Random(seed), Tally()
    await _bases(folder)
    before = {name: _read_copy(folder, name) for name in ("closed", "killed")}
    kinds = [*KINDS]
    for run in range(runs):
        kind = kinds[run % len(kinds)]
        base, change = KINDS[kind]
        with tempfile.TemporaryDirectory(dir=folder) as fresh:
            file = _copied(folder, base, Path(fresh))
            change(file, rng)
            after = _read_copy(Path(fresh), base)
            by = await _noticed(file)
        tally.runs += 1
        if by is not None:
            tally.noticed[kind] += 1
            tally.by[by] += 1
        elif after == before[base]:
            tally.harmless[kind] += 1
        else:
            tally.missed.append(kind)
    return tally


def _copied(folder, base, fresh):
    for part in _PARTS:
        if Path(f"{folder}/{base}{part}").exists():
            shutil.copy(f"{folder}/{base}{part}", fresh / f"{base}{part}")
    shutil.copy(folder / "other", fresh / "other")
    return fresh / base


def _read_copy(folder, base):
    """Return what a database says, read from a copy: reading may take over the log."""
    with tempfile.TemporaryDirectory(dir=folder) as aside:
        for part in _PARTS:
            if Path(f"{folder}/{base}{part}").exists():
                shutil.copy(f"{folder}/{base}{part}", aside)
        return _read(f"{aside}/{base}")


def told(tally):
    """Return what was noticed, in words."""
    lines = [f"{kind}: {tally.noticed[kind]} noticed{_harmless(tally.harmless[kind])}\n" for kind in KINDS]
    return "".join(lines) + (
        f"{tally.runs} ways: {sum(tally.noticed.values())} noticed, {sum(tally.harmless.values())} changed "
        f"nothing that is read, {len(tally.missed)} missed {tally.missed or ''}; by {dict(tally.by)}\n"
    )


def _harmless(times):
    return f", {times} where nothing reads otherwise" if times else ""


if __name__ == "__main__":
    from_command_line(__doc__, "tampering", tampering, told, runs=500, seed=1)
