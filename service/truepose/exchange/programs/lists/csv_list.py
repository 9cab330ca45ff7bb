"""Lists of targets as a table (.csv). Cells that are no numbers of targets stay as they are."""

import re
from collections.abc import Iterator
from typing import Final

from truepose.exchange.errors import MissingEntryError
from truepose.exchange.programs.draft import Draft
from truepose.exchange.programs.lists.target_rows import NAME, NEST, joint_names, required, target_of
from truepose.exchange.programs.source import Source
from truepose.exchange.tables.table import WHOLE, Column, column_names, read_table

_CELL: Final = re.compile(r'[ \t]*(?:"(?P<quoted>(?:""|[^"])*)"[ \t]*|(?P<plain>[^,]*?)[ \t]*)(?:,|$)')


def read(draft: Draft) -> None:
    """Read a table of targets; raises InputFileError as any table does, with the name of the column."""
    source = draft.source
    names = column_names(source.name, source.data)
    if NAME not in names:
        raise MissingEntryError(f"column {NAME} is missing; it is required", file=source.name, line=1)
    wanted = dict.fromkeys((*required(names), *joint_names(names)))
    columns = [Column(name) for name in wanted]
    columns.append(Column(NEST, required=False, rules=(WHOLE,)))
    table = read_table(source.name, source.data, columns, passed_over={NAME})
    nests = table.optional_whole(NEST)
    for row, line in enumerate(table.lines.tolist()):
        cells = dict(zip(names, _cells(source, line, len(names)), strict=True))
        held = {name: source.number(*cells[name]) for name in wanted}
        name = source.shown(*cells[NAME]).replace('""', '"') or f"line {line}"
        draft.add(target_of(source, name, line, held, None if nests is None else int(nests[row])))


def _cells(source: Source, line: int, count: int) -> list[tuple[int, int]]:
    """Return where the cells of a line stand, without blanks and quotation marks."""
    spans = list(_spans(source, line))
    if len(spans) != count:
        source.fail(
            "a cell goes on in the next line; in a list of targets none does", source.line_span(line)[0]
        )
    return spans


def _spans(source: Source, line: int) -> Iterator[tuple[int, int]]:
    at, end = source.line_span(line)
    while at <= end:
        found = _CELL.match(source.text, at, end)
        if found is None:
            return
        yield found.span("plain" if found["quoted"] is None else "quoted")
        if found.end() == end and not source.text.endswith(",", at, end):
            return
        at = found.end()
