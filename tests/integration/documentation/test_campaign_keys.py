"""The page on optional parts of a campaign names them all."""

import re
from pathlib import Path

import pytest

from truepose.exchange.campaigns.description import KEYS, ROLES
from truepose.exchange.tables.ballbar import leg_columns
from truepose.exchange.tables.points import point_columns

_PAGE = (Path(__file__).parents[3] / "docs" / "campaign-keys.md").read_text(encoding="utf-8")
_ALWAYS = {"format", "robot", "dhm_nominal", "gravity_m_s2_world", "robot_repeatability_mm", "files"}
_ALWAYS_READ = {"calibration", "legs"}
_RUNS = {r"tau\d+_Nm": "`tau1_Nm`..", r"dir\d+": "`dir1`..", r"c[xyz]{2}": "`cxx` to `czz`"}


def _as_written(column):
    """A column as the page has it: of columns that belong together, the first ones."""
    return next((told for run, told in _RUNS.items() if re.fullmatch(run, column)), column)


@pytest.mark.parametrize("key", sorted(KEYS - _ALWAYS))
def test_every_optional_key_is_on_the_page(key):
    assert f"`{key}`" in _PAGE


@pytest.mark.parametrize("role", sorted(set(ROLES) - _ALWAYS_READ))
def test_every_further_table_is_on_the_page(role):
    assert f"`{role}`" in _PAGE


def test_every_optional_column_is_on_the_page():
    columns = [*point_columns(6, (1,)), *leg_columns(6, (1,))]

    missing = {c.name for c in columns if not c.required and _as_written(c.name) not in _PAGE}

    assert missing == set()


def test_the_page_names_no_key_that_is_not_read():
    rows = re.search(r"## Keys(.*?)## Columns", _PAGE, flags=re.DOTALL).group(1)
    first_cells = re.findall(r"^\| (.*?) \|", rows, flags=re.MULTILINE)
    named = {name for cell in first_cells for name in re.findall(r"`([a-zA-Z_0-9]+)`", cell)}

    of_a_row = {"sign", "beta_deg"}  # of `dhm_nominal`
    assert named - {"null"} - of_a_row <= KEYS | set(ROLES)
