"""The outbox of a cell: its chain as its plant reads it, each link with its record where that leaves.

Which records leave is decided by table. Of one that stays at home only its link leaves: number, stream, table
and hash. The hash is what the next record of its stream rests on, so that the chain can be followed over it
and all around it be verified.

What may open something is taken out. Which options a device has its driver decides, which somebody else may
have written. So they stay at home, except numbers and what is known here to open nothing.

A record leaves as JSON from which its hash can be computed anew. Text and whole numbers are JSON's own. A
float is `{"float": "0.1"}`, the shortest decimal that is exactly it, bytes are `{"base64": "..."}`. JSON
itself does not tell 3.0 from 3, and to the chain they are two values.
"""

import base64
import binascii
import json
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from sqlalchemy import Connection, Row, RowMapping, select

from truepose.storage.engine.dialects import as_kept
from truepose.storage.engine.raw_connection import plain
from truepose.storage.errors import UnreadableRowError
from truepose.storage.integrity.head_hash import Head, head_after
from truepose.storage.queries import Repository
from truepose.storage.tables import LARGE, links, metadata

# A list of what leaves: a table that nobody has thought of stays at home.
LEAVING: Final = frozenset({
    "sessions",
    "session_states",
    "readings",
    "notes",
    "added_stops",
    "closings",
    "session_entries",
    "campaigns",
    "jobs",
    "job_states",
    "identifications",
    "diagnoses",
    "models",
    "validations",
    "corrections",
    "events",
    "reports",
    "series",
    "deliveries",
    "handed_down",
    "hand_down_uses",
})
# People and what opens the service to them, what they did and from where, and the keys of their requests.
AT_HOME: Final = frozenset({
    "people",
    "person_states",
    "credentials",
    "revocations",
    "acts",
    "request_keys",
    "act_answers",
    "links",
    # What a plant has of its cells leaves it for nobody.
    "plant_cells",
    "plant_branches",
    "plant_visits",
    "plant_journal",
    "plant_sessions",
    "plant_days",
    "plant_results",
    "plant_told",
    "plant_certificates",
    "plant_robots",
    "plant_instruments",
    "plant_hand_downs",
    "plant_hand_down_states",
})


# Likewise for options, whose names a driver of somebody else's may have chosen.
HARMLESS: Final = frozenset({  # options whose text says where a device is, and how it counts
    "channels",
    "host",
    "joint_3_from",
    "joint_speeds_deg_s",
    "probe",
    "reflector",
    "reversed",
    "serial",
    "signs",
    "terminator",
    "tool_file",
    "tool_mm",
    "usb",
})
_SET_UP: Final = "setup"  # of a session: the cell with the options of its devices
_OPTIONS: Final = "options"
_TAKEN_OUT: Final = "taken out"
_OPENING: Final = re.compile(
    r"passw|passphrase|passcode|pincode|pwd|secret|token|credential|(api|access|private)key"
)
_OPENING_WORDS: Final = frozenset({"pass", "pin", "pw"})  # only as words: a spindle opens nothing
_USER_INFO: Final = re.compile(r"://\S*@")
_USER_INFO_OF_OPTION: Final = re.compile(r"^([\w+.-]+://)?.*@", re.DOTALL)


def without_secrets(row: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a record as it may leave: itself, or with what may open something taken out of its set-up.

    The latter has no longer the hash of its link: it can be read, and not verified.
    """
    if not isinstance(row.get(_SET_UP), str):
        return row
    set_up = json.loads(row[_SET_UP])
    told = _told(set_up)
    # The same object where nothing was taken out: then the hash of the link can be computed anew from what
    # leaves.
    return row if told == set_up else {**row, _SET_UP: json.dumps(told)}


def _told(document: Any) -> Any:
    match document:
        case dict():
            return {name: _told_under(name, value) for name, value in document.items()}
        case list():
            return [_told(value) for value in document]
        case str():
            return _USER_INFO.sub("://", document)
        case _:
            return document


def _told_under(name: str, value: Any) -> Any:
    if _opens(name):
        return _TAKEN_OUT
    if name == _OPTIONS and isinstance(value, dict):
        return {option: _told_option(option, one) for option, one in value.items()}
    return _told(value)


def _told_option(name: str, value: Any) -> Any:
    if _opens(name):
        return _TAKEN_OUT
    match value:
        # A number opens nothing by itself: PINs and the like are caught by their names before.
        case bool() | int() | float() | None:
            return value
        case str() if name in HARMLESS:
            return _USER_INFO_OF_OPTION.sub(r"\1", value)
        case _:
            return _TAKEN_OUT


def _opens(name: str) -> bool:
    """Whether what has such a name may open something, however somebody writes it."""
    words = re.split(r"[^a-z0-9]+", name.lower())
    return bool(_OPENING.search("".join(words))) or not _OPENING_WORDS.isdisjoint(words)


Value: TypeAlias = str | int | float | bytes | None
WHOLE_NUMBERS: Final = range(-(2**63), 2**63)  # that a database holds
_FLOAT: Final = "float"
_BYTES: Final = "base64"


def to_typed_json(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the database as JSON can hold it, without columns that are null."""
    return {name: _written(value) for name, value in row.items() if value is not None}


def from_typed_json(document: Any) -> dict[str, Value]:
    """Return the row that a document holds; raises UnreadableRowError where it holds none."""
    if not isinstance(document, dict):
        raise UnreadableRowError(f"A record is an object with a value for each column, not {document!r:.60}.")
    return {name: _read(name, value) for name, value in document.items()}


def _written(value: Any) -> Any:
    match value:
        # `repr` is the shortest decimal that is exactly this double, so the hash can be computed from it.
        case float():
            return {_FLOAT: repr(value)}
        case bytes() | bytearray() | memoryview():
            return {_BYTES: base64.b64encode(value).decode()}
        case _:
            return value


def _read(name: str, value: Any) -> Value:
    match value:
        # Neither is a value of a row in its JSON: a float comes as text, and the database has no truth
        # values.
        case bool() | float():
            pass
        case str():
            return value
        # Beyond 64 bits no database keeps it, and the library would raise what nobody here waits for.
        case int() if value in WHOLE_NUMBERS:
            return value
        case {"float": str(decimal)} if len(value) == 1:
            return _float(name, decimal)
        case {"base64": str(text)} if len(value) == 1:
            return _bytes(name, text)
    raise UnreadableRowError(f"The column {name} holds {value!r:.60}, which is not a value of a record.")


def _float(name: str, decimal: str) -> float:
    try:
        return float(decimal)
    except ValueError as error:
        raise UnreadableRowError(
            f"The column {name} holds {decimal!r:.60}, which is not a number."
        ) from error


def _bytes(name: str, text: str) -> bytes:
    try:
        return base64.b64decode(text, validate=True)
    except binascii.Error as error:
        raise UnreadableRowError(f"The column {name} holds bytes that cannot be read ({error}).") from error


_AT_A_TIME: Final = 100  # links that are read in one turn: whoever measures is never behind more


@dataclass(frozen=True, slots=True)
class OutboxLink:
    """A link of the chain, with its record where that leaves the cell."""

    id: int
    stream: int
    record: str  # name of its table
    record_id: int
    hash: bytes
    row: Mapping[str, Any] | None = None  # None: it stays at home, or a secret was taken out of it
    told: Mapping[str, Any] | None = None  # the record without its secret; None: it has none


@dataclass(frozen=True, slots=True)
class ChainPosition:
    """How far a chain goes, and what it was at some link of it."""

    newest: int
    head: Head  # at the link asked for, or at the newest one where it does not go that far
    hash: bytes | None  # of that link; None: of a chain without any


class Outbox(Repository):
    """All queries about what leaves a cell."""

    async def stand(self, at: int | None = None) -> ChainPosition:
        """Return the head of the chain as it was at a link, by default as it is."""
        return await self._database.read(lambda connection: _stand(connection, at))

    async def newest(self) -> int:
        """Return the number of the newest link; 0: there is none."""
        return await self._database.read(_newest)

    async def after(self, number: int, limit: int) -> Sequence[OutboxLink]:
        """Return some links above a number, at most `limit`; none: there are no more.

        Large records come one at a time, so that memory holds no more than one of them.
        """
        # A transaction of a reader keeps the log from being taken over; a plant that reads a million links
        # must not do so in one.
        most = min(limit, _AT_A_TIME)
        return await self._database.read(lambda connection: _after(connection, number, most))


def _stand(connection: Connection, at: int | None) -> ChainPosition:
    newest = _newest(connection)
    number = newest if at is None else min(at, newest)
    found = connection.scalar(select(links.c.hash).where(links.c.id == number))
    head = head_after(plain(connection), number)
    return ChainPosition(newest, head, None if found is None else bytes(found))


def _newest(connection: Connection) -> int:
    return int(connection.scalar(select(links.c.id).order_by(links.c.id.desc()).limit(1)) or 0)


def _after(connection: Connection, number: int, most: int) -> list[OutboxLink]:
    found = connection.execute(select(links).where(links.c.id > number).order_by(links.c.id).limit(most))
    some = _up_to_large(found.all())
    rows = _rows(connection, some)
    return [_leaving(link, rows.get((link.record, link.record_id))) for link in some]


def _up_to_large(found: Sequence[Row[Any]]) -> Sequence[Row[Any]]:
    large = next((place for place, link in enumerate(found) if link.record in LARGE), len(found))
    return found[: max(large, 1)]


def _rows(connection: Connection, some: Iterable[Row[Any]]) -> dict[tuple[str, int], RowMapping]:
    wanted: defaultdict[str, list[int]] = defaultdict(list)
    for link in some:
        if link.record in LEAVING:
            wanted[link.record].append(link.record_id)
    return {
        (table, row["id"]): row
        for table, numbers in wanted.items()
        for row in _of(connection, table, numbers)
    }


def _of(connection: Connection, table: str, numbers: Sequence[int]) -> Sequence[RowMapping]:
    """Return records as they are kept, not as their columns are read: the hash is of what is kept."""
    kept = metadata.tables[table]
    query = select(*(as_kept(column).label(column.name) for column in kept.c))
    return connection.execute(query.where(kept.c.id.in_(numbers))).mappings().all()


def _leaving(link: Row[Any], kept: RowMapping | None) -> OutboxLink:
    named = (link.id, link.stream, link.record, link.record_id, bytes(link.hash))
    if kept is None:
        return OutboxLink(*named)
    row = dict(kept)
    told = without_secrets(row)
    return OutboxLink(*named, row) if told is row else OutboxLink(*named, told=told)
