"""What each engine says in its own words, said once: values inside JSON columns, places in texts, moments.

A path reads as SQLite has it: "$" is the document, "$.cell.robot" what stands in it under these names.
"""

from typing import Any

from sqlalchemy import JSON, Boolean, ColumnElement, Float, Integer, cast, literal_column
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.compiler import SQLCompiler
from sqlalchemy.sql.functions import FunctionElement

from truepose.storage.column_types import TEXT, WHOLE


class _Inside(FunctionElement[Any]):
    """Of what stands at a path in a JSON column."""

    inherit_cache = True

    def __init__(self, column: Any, path: str = "$") -> None:
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
    return kept_text(column) if isinstance(column.type, JSON) else column


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
