"""Tables that a program has in memory are read by the rules of the files, with row and column of a fault."""

import csv
import io
import json

import numpy as np
import pytest

from tests.helpers.domain.builders import make_ballbar_campaign, make_campaign
from truepose.exchange.campaigns.folder import (
    DESCRIPTION,
    campaign_files,
    campaign_from,
    campaign_from_arrays,
)
from truepose.exchange.errors import (
    BadValueError,
    InputFileError,
    MissingEntryError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose.exchange.tables.files import held_out_readings, points_to_predict


def _arrays(text):
    """The columns of a CSV text as a notebook has them: numbers where all are, NaN for what is empty."""
    rows = list(csv.reader(io.StringIO(text)))
    return {name: _array(cells) for name, cells in zip(rows[0], zip(*rows[1:], strict=True), strict=True)}


def _array(cells):
    try:
        return np.array([float(cell or "nan") for cell in cells])
    except ValueError:
        return np.array(cells, dtype=object)


def _in_memory(campaign):
    """The keys and tables of a campaign, as a program would give them."""
    files = campaign_files(campaign)
    keys = json.loads(files.pop(DESCRIPTION))
    return keys, {name.removesuffix(".csv"): _arrays(text) for name, text in files.items()}


@pytest.mark.parametrize("make", [make_campaign, make_ballbar_campaign])
def test_arrays_give_the_campaign_that_files_of_the_same_numbers_give(make):
    files = campaign_files(make())

    from_arrays = campaign_from_arrays(*_in_memory(make()))

    assert campaign_files(from_arrays) == campaign_files(campaign_from(lambda name: files[name].encode()))


def _points(**changes):
    points = {
        "config": np.array([1, 2, 3]),
        "q1_deg": np.array([0.0, 10.0, 20.0]),
        "nest": np.array([1, 1, 1]),
        "x_mm": np.array([100.0, 110.0, 120.0]),
        "y_mm": np.array([0.0, 1.0, 2.0]),
        "z_mm": np.array([300.0, 300.0, 300.0]),
        "u_mm": np.array([0.02, 0.02, 0.02]),
    }
    return {name: column for name, column in (points | changes).items() if column is not None}


@pytest.mark.parametrize(
    ("changes", "error", "sentence"),
    [
        ({"u_mm": None}, MissingEntryError, "points: column u_mm is missing; it is required."),
        (
            {"x_mm": None, "x_m": np.ones(3)},
            WrongUnitError,
            "points: column x_m has the unit m; x_mm in mm is required.",
        ),
        (
            {"y_mm": np.array([0.0, np.nan, 2.0])},
            BadValueError,
            "points, row 1, column y_mm: the cell is empty; a number is required.",
        ),
        (
            {"y_mm": np.array([0.0, 1.0, -np.inf])},
            BadValueError,
            "points, row 2, column y_mm: '-inf' is not a finite number.",
        ),
        (
            {"z_mm": np.array([300.0, "three", 300.0], dtype=object)},
            BadValueError,
            "points, row 1, column z_mm: 'three' is not a number.",
        ),
        ({"nest": np.array([1, 2, 1])}, BadValueError, "points, row 1, column nest: '2' must be one of"),
        ({"u_mm": np.array([0.02, 0.0, 0.02])}, BadValueError, "row 1, column u_mm: '0.0' must be greater"),
        ({"config": np.array([1.0, 1.5, 2.0])}, BadValueError, "'1.5' must be a whole number"),
        ({"config": np.array([1, 2, 2])}, BadValueError, "configuration 2 is on row 1 with other joints"),
        ({"qw": np.ones(3)}, MissingEntryError, "points: column qx is missing; qw to qz must all be given"),
        ({"x_mm": np.array([100.0, 1e9, 120.0])}, BadValueError, "not a plausible length"),
        (
            {"u_along_mm": np.full(3, 0.01), "u_across_mm": np.full(3, 0.02)},
            MissingEntryError,
            "points, column u_along_mm: u_along_mm and u_across_mm need",
        ),
        (dict.fromkeys(_points(), np.zeros(0)), UnreadableFileError, "points: the table has no rows."),
    ],
)
def test_a_fault_in_an_array_is_placed_by_row_and_column(changes, error, sentence):
    with pytest.raises(error) as refused:
        held_out_readings("points", _points(**changes), 1, {1})

    assert sentence in str(refused.value)
    assert refused.value.line is None


def test_a_sound_table_says_nothing():
    table = held_out_readings("points", _points(), 1, {1})

    assert table.ignored == ()
    assert table.readings.position_mm[1].tolist() == [110.0, 1.0, 300.0]


def test_columns_of_legs_announce_legs():
    columns = ("placement", "config", "q1_deg", "base_point", "tool_point", "length_mm", "u_mm")

    table = held_out_readings("legs", {name: np.array([1, 1]) for name in columns}, 1, {1})

    assert table.readings.length_mm.tolist() == [1.0, 1.0]


def test_what_is_unknown_of_a_stop_may_be_nan_or_none():
    given = {"time_s": np.array([0.0, np.nan, 2.0]), "attachment": np.array([1, 1, 2], dtype=object)}

    stops = points_to_predict(
        "points", _points(**given, dir1=np.array([1, None, -1], dtype=object)), 1, {1}
    ).stops

    assert np.isnan(stops.time_s).tolist() == [False, True, False]
    assert stops.direction[:, 0].tolist() == [1, 0, -1]
    assert stops.attachment.tolist() == [1, 1, 2]


def test_a_key_that_cannot_be_meant_is_named():
    keys, tables = _in_memory(make_campaign())

    with pytest.raises(InputFileError, match=r"^campaign, key tool_nests_mm: the list is empty"):
        campaign_from_arrays(keys | {"tool_nests_mm": []}, tables)
