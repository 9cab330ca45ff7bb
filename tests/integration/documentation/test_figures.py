"""The tables of figures have their columns, and nothing that was measured lacks its origin."""

import csv
import re
from pathlib import Path

import pytest

_FOLDER = Path(__file__).parents[3] / "docs" / "figures"
_TABLES = sorted(path for path in _FOLDER.glob("*.csv") if path.stem != "expectations")
_COMMIT = re.compile(r"(by )?[0-9a-f]{8}|unknown")


@pytest.mark.parametrize("table", _TABLES, ids=lambda path: path.stem)
def test_every_figure_says_what_was_measured_how_where_and_by_which_commit(table):
    with table.open(newline="", encoding="utf-8") as file:
        heads, *rows = csv.reader(file)

    assert heads == ["figure", "goal", "measured", "method", "machine", "commit"]
    assert [row for row in rows if not all((row[0], *row[2:]))] == []
    assert [row[-1] for row in rows if not _COMMIT.fullmatch(row[-1])] == []


def test_every_table_is_listed():
    listed = (_FOLDER / "README.md").read_text(encoding="utf-8")

    assert [path.name for path in _FOLDER.glob("*.csv") if f"({path.name})" not in listed] == []
