"""Points files of `predict` and `validate`, and what `predict` writes."""

import math

import numpy as np
import pytest

from tests.helpers.domain.builders import make_ballbar_campaign
from truepose.domain.campaign import LegReadings, PointReadings
from truepose.exchange.campaigns.folder import campaign_files
from truepose.exchange.errors import BadValueError, MissingEntryError, MissingFileError, WrongUnitError
from truepose.exchange.import_wizard.single_table import read_points_to_predict, read_validation_file
from truepose.exchange.tables.files import write_predictions
from truepose.messages.catalogue import english

TABLES = campaign_files(make_ballbar_campaign())


def file_of(folder, text):
    path = folder / "points.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_configurations_alone_are_enough_to_predict(tmp_path):
    wanted = read_points_to_predict(file_of(tmp_path, "config,q1_deg,q2_deg\n7,90,0\n3,0,45\n"), 2, {1, 2})

    assert wanted.stops.config.tolist() == [7, 3]  # the order of the file
    assert wanted.stops.joints_rad[0, 0] == pytest.approx(math.pi / 2, rel=1e-15)
    assert wanted.nest is None
    assert wanted.stops.direction is None


def test_what_is_known_of_the_stops_is_used_to_predict(tmp_path):
    text = "nest,config,q1_deg,dir1,time_s,temperature_C,attachment,tau1_Nm\n2,1,0,-1,5.5,,4,1.5\n"

    wanted = read_points_to_predict(file_of(tmp_path, text), 1, {1, 2})

    stops = wanted.stops
    assert (wanted.nest[0], stops.direction[0, 0], stops.time_s[0], stops.attachment[0]) == (2, -1, 5.5, 4)
    assert stops.torque_n_mm[0, 0] == 1500.0
    assert math.isnan(stops.temperature_c[0])


@pytest.mark.parametrize("table", ["validation.csv", "legs.csv"])
def test_measured_values_are_passed_over_in_silence(tmp_path, table):
    wanted = read_points_to_predict(file_of(tmp_path, TABLES[table].replace("300.", "none.")), 3, {1})

    assert wanted.ignored == ()
    assert wanted.stops.config.tolist() == [1, 2, 3]


def test_a_column_that_is_not_understood_is_named(tmp_path):
    wanted = read_points_to_predict(file_of(tmp_path, "config,q1_deg,shift\n1,0,late\n"), 1, {1})

    assert tuple(map(english, wanted.ignored)) == (
        "points.csv: column shift is not part of the format and is ignored.",
    )


@pytest.mark.parametrize(
    ("text", "kind", "line", "column"),
    [
        ("config,q1_deg\n1,x\n", BadValueError, 2, "q1_deg"),
        ("config,q1_rad\n1,0\n", WrongUnitError, 1, None),
        ("config\n1\n", MissingEntryError, 1, None),
        ("config,q1_deg,nest\n1,0,1\n1,0,3\n", BadValueError, 3, "nest"),
        ("config,q1_deg\n1.5,0\n", BadValueError, 2, "config"),
    ],
    ids=["text", "radians", "no joints", "unknown nest", "half a configuration"],
)
def test_a_mistake_in_the_points_to_predict_is_refused_where_it_is(tmp_path, text, kind, line, column):
    with pytest.raises(kind) as refusal:
        read_points_to_predict(file_of(tmp_path, text), 1, {1, 2})

    assert (refusal.value.file, refusal.value.line, refusal.value.column) == ("points.csv", line, column)


def test_a_points_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(MissingFileError, match=r"points.csv: there is no such file\."):
        read_points_to_predict(tmp_path / "points.csv", 1, {1})


@pytest.mark.parametrize(
    ("table", "kind"),
    [("validation.csv", PointReadings), ("validation_legs.csv", LegReadings)],
)
def test_the_header_says_whether_points_or_legs_are_validated(tmp_path, table, kind):
    validation = read_validation_file(file_of(tmp_path, TABLES[table]), 3, {1})

    assert isinstance(validation.readings, kind)


def test_a_file_of_neither_misses_the_position(tmp_path):
    with pytest.raises(MissingEntryError, match="column nest is missing"):
        read_validation_file(file_of(tmp_path, "config,q1_deg\n1,0\n"), 1, {1})


def test_predictions_are_written_in_the_promised_columns(tmp_path):
    path = tmp_path / "out.csv"
    position = np.array([[1.0, -2.5, 3.000004], [4.0, 5.0, 1e-9]])

    write_predictions(path, np.array([9, 2]), np.array([1, 3]), position, np.array([0.0123456, 0.05]))

    assert path.read_text() == (
        "config,nest,x_mm,y_mm,z_mm,u_mm\n"
        "9,1,1.00000,-2.50000,3.00000,0.01235\n"
        "2,3,4.00000,5.00000,0.00000,0.05000\n"
    )
