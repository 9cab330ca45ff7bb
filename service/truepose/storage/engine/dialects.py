"""Columns, tables and expressions as every engine has them: what is written comes back bit for bit.

A path reads as SQLite has it: "$" is the document, "$.cell.robot" what stands in it under these names.
"""

import json
import math
from typing import Any, Final

import sqlalchemy as sa
from sqlalchemy import JSON, Boolean, ColumnElement, Float, Integer, cast, literal_column, type_coerce
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.schema import SchemaItem
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement

from truepose.messages.message import Message, Text
from truepose.storage.documents import from_document, from_json, to_document

# Compared and sorted byte by byte, as SQLite does it by itself, whatever language a server speaks.
TEXT: Final = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
WHOLE: Final = sa.Integer().with_variant(sa.BigInteger(), "postgresql")
DOCUMENT: Final = sa.JSON()  # of PostgreSQL `json`, which keeps the text as it was given; `jsonb` would not
BYTES: Final = sa.LargeBinary()
_JSON: Final = ("{", '"')  # how an object and a text of JSON begin


# Bound values only; what comes back is the engine's. PostgreSQL keeps -0.0 and NaN where SQLite does not, and
# a copied record must have the same hash on both (decision 0061).
class Real(sa.TypeDecorator[float]):
    """A double as SQLite keeps it, which knows no negative zero and no NaN, so that hashes are the same."""

    impl = sa.Float
    cache_ok = True

    def process_bind_param(self, value: float | None, dialect: Any) -> float | None:
        """Return what is kept of a number."""
        # Adding zero turns -0.0 into 0.0 and leaves every other number as it is.
        return None if value is None or math.isnan(value) else float(value) + 0.0


class Said(sa.TypeDecorator[Text]):
    """What is said to people: a message as its key and values, in JSON; somebody's own words as they are."""

    impl = TEXT
    cache_ok = True

    def process_bind_param(self, value: Text | None, dialect: Any) -> str | None:
        """Return what is kept of a text; words that look like JSON are kept as JSON, to be told apart."""
        # Without this a person could type the JSON of a message, and the record would say it in the service's
        # words (decision 0078).
        if value is None or (isinstance(value, str) and not value.startswith(_JSON)):
            return value
        return json.dumps(to_document(value), ensure_ascii=False)

    def process_result_value(self, value: str | None, dialect: Any) -> Text | None:
        """Return a text that was kept."""
        if value is None or not value.startswith(_JSON):
            return value
        kept = from_json(value)
        return from_document(Message, kept) if isinstance(kept, dict) else str(kept)


REAL: Final = Real()
SAID: Final = Said()


class _Inside(FunctionElement[Any]):
    """Of what stands at a path in a JSON column."""

    inherit_cache = True

    def __init__(self, column: Any, path: str = "$") -> None:
        # Paths are constants of this program and never what somebody typed, so they may stand in the
        # statement.
        super().__init__(column, literal_column(f"'{path}'"))


class text_at(_Inside):  # noqa: N801 - called like a function of SQL
    """The text or number there, as text; of a list or an object its JSON; null where nothing or null is."""

    name = "text_at"
    type = TEXT
    inherit_cache = True


class truth_at(_Inside):  # noqa: N801
    """Whether `true` is there; null where nothing or null is."""

    name = "truth_at"
    type = Boolean()
    inherit_cache = True


class is_object_at(_Inside):  # noqa: N801
    """Whether an object is there."""

    name = "is_object_at"
    type = Boolean()
    inherit_cache = True


class length_at(_Inside):  # noqa: N801
    """How many entries the list there has; null where none is."""

    name = "length_at"
    type = WHOLE
    inherit_cache = True


class entries_at(_Inside):  # noqa: N801
    """The entries of the list there, a row each: `entries_at(column).table_valued("value")`."""

    name = "entries_at"
    inherit_cache = True


class kept_text(FunctionElement[str]):  # noqa: N801
    """A JSON column as the text that is kept."""

    name = "kept_text"
    type = TEXT
    inherit_cache = True


def as_kept(column: Any) -> Any:
    """Return what of a column is in the hash of its record."""
    if isinstance(column.type, JSON):
        return kept_text(column)
    return type_coerce(column, TEXT) if isinstance(column.type, Said) else column


class position_of(FunctionElement[int]):  # noqa: N801
    """Where one text begins in another, from 1; 0 where it does not."""

    name = "position_of"
    type = Integer()
    inherit_cache = True


class leading_number(FunctionElement[int]):  # noqa: N801
    """The number that a text begins with."""

    name = "leading_number"
    type = WHOLE
    inherit_cache = True


class moment_s(FunctionElement[float]):  # noqa: N801
    """A moment in ISO 8601 as seconds, from whenever the engine counts."""

    name = "moment_s"
    type = Float()
    inherit_cache = True


def number_at(column: Any, path: str) -> ColumnElement[int]:
    """Return the whole number at a path of a JSON column; null where nothing or null is."""
    return cast(text_at(column, path), WHOLE)


class newest_number(FunctionElement[int]):  # noqa: N801
    """The newest number that a table with the column `id` has given, 0 before the first."""

    name = "newest_number"
    type = WHOLE
    inherit_cache = True

    def __init__(self, table: str) -> None:
        super().__init__(literal_column(f"'{table}'"), literal_column(table))


# A default of the column, so that it is asked inside the writing transaction, of which there is one at a
# time.
class next_number(FunctionElement[int]):  # noqa: N801
    """The number of a new record in a table with the column `id`.

    SQLite gives it, and none twice. On PostgreSQL it is the newest one's and one more: a sequence would leave
    gaps behind refused records, in which records taken out could hide.
    """

    name = "next_number"
    type = WHOLE
    inherit_cache = True

    def __init__(self, table: str) -> None:
        super().__init__(literal_column(table))


_SQLITE = {
    text_at: "json_extract({}, {})",
    truth_at: "(nullif(json_type({}, {}), 'null') = 'true')",
    is_object_at: "(coalesce(json_type({}, {}), 'null') = 'object')",
    length_at: "json_array_length({}, {})",
    entries_at: "json_each({}, {})",
    kept_text: "{}",
    position_of: "instr({}, {})",
    leading_number: "CAST({} AS INTEGER)",
    moment_s: "(86400.0 * julianday({}))",
    newest_number: "coalesce((SELECT seq FROM sqlite_sequence WHERE name = {}), 0)",
    next_number: "NULL",
}
_POSTGRESQL = {
    text_at: '((({})::json #>> {}) COLLATE "C")',
    truth_at: "((({})::json #>> {}) = 'true')",
    is_object_at: "(coalesce(json_typeof(({})::json #> {}), 'null') = 'object')",
    length_at: "json_array_length(({})::json #> {})",
    entries_at: "json_array_elements_text(({})::json #> {})",
    kept_text: "({})::text",
    position_of: "strpos({}, {})",
    leading_number: "CAST(substring({} FROM '^[0-9]+') AS BIGINT)",
    moment_s: "CAST(extract(epoch FROM CAST({} AS timestamptz)) AS double precision)",
    newest_number: "(SELECT coalesce(max(id), 0) FROM {1})",
    next_number: "(SELECT coalesce(max(id), 0) + 1 FROM {})",
}


def _names(path: str) -> str:
    """Return '{cell,robot}' of '$.cell.robot', quotes and all."""
    return "'{" + path.strip("'").removeprefix("$").removeprefix(".").replace(".", ",") + "}'"


def _say(kind: type[FunctionElement[Any]]) -> None:
    @compiles(kind, "sqlite")
    def say_to_sqlite(element: Any, compiler: SQLCompiler, **options: Any) -> str:
        return _SQLITE[kind].format(*_processed(element, compiler, options))

    @compiles(kind, "postgresql")
    def say_to_postgresql(element: Any, compiler: SQLCompiler, **options: Any) -> str:
        values = _processed(element, compiler, options)
        if isinstance(element, _Inside):
            values[1] = _names(values[1])
        return _POSTGRESQL[kind].format(*values)


def _processed(element: Any, compiler: SQLCompiler, options: dict[str, Any]) -> list[str]:
    return [compiler.process(clause, **options) for clause in element.clauses]


for _kind in _SQLITE:
    _say(_kind)


metadata = sa.MetaData()


def number(table: str) -> sa.Column[int]:
    """Return the number of a record."""
    # On SQLite AUTOINCREMENT gives no number twice, also after its record is gone: `sqlite_sequence` then
    # tells that one is missing.
    return sa.Column("id", WHOLE, primary_key=True, autoincrement=True, default=next_number(table))


def recorded_time() -> sa.Column[str]:
    """Return when a record was written."""
    return sa.Column("recorded_at", TEXT, nullable=False)


def reference(name: str, target: str, *, nullable: bool = False) -> sa.Column[int]:
    """Return a reference to a record of another table."""
    return sa.Column(name, WHOLE, sa.ForeignKey(f"{target}.id"), nullable=nullable)


def records(name: str, *columns: SchemaItem) -> sa.Table:
    """Return a table of records."""
    return sa.Table(name, metadata, number(name), recorded_time(), *columns, sqlite_autoincrement=True)


def records_of_sessions(name: str, *columns: SchemaItem) -> sa.Table:
    """Return a table of records that each belong to a session."""
    found = sa.Index(f"ix_{name}_session_id", "session_id", "id")
    return records(name, reference("session_id", "sessions"), *columns, found)
