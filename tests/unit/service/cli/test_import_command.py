"""`truepose import`: from another program's points to a campaign folder."""

import json
from datetime import date, datetime

import numpy as np
import pytest

from tests.helpers.checkout import CHECKOUT
from tests.helpers.exchange.rows import read_rows
from tests.helpers.exchange.workbooks import workbook
from tests.unit.service.exchange.import_wizard.tables import plain, readings, table
from truepose.cli.imports import LengthUnit, import_command
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.folder import read_campaign

JOINTS = ["config", *(f"q{joint}_deg" for joint in range(1, 7)), "nest"]
NESTS = ["0,0,125", "75,93.675,215", "150,0,125"]


@pytest.fixture
def exported(tmp_path):
    """The example's readings as two files: points of a tracker's software, and joint angles."""
    rows = read_rows(CHECKOUT / "docs/examples/campaign/calibration.csv")
    points = [f"A Group P{row['config']} {row['x_mm']} {row['y_mm']} {row['z_mm']}" for row in rows]
    (tmp_path / "points.txt").write_text(
        "\n".join(["// Units: Millimeters", *points[:-2], "A Group P999 1 2 3"])
    )
    joints = [",".join(row[name] for name in JOINTS) for row in rows]
    (tmp_path / "joints.csv").write_text("\n".join([",".join(JOINTS), *joints]))
    return tmp_path


def imported(folder, out="mine", **options):
    given = {"robot": "abb-irb-120", "u_mm": 0.015, "nest": NESTS} | options
    return import_command(folder / "points.txt", folder / "joints.csv", out=folder / out, **given)


def test_the_campaign_has_the_readings_as_they_were(exported, capsys):
    assert imported(exported, nest_u_mm=0.002) == 0

    original = read_campaign(CHECKOUT / "docs/examples/campaign").calibration
    campaign = read_campaign(exported / "mine")
    assert len(campaign.calibration) == len(original) - 2
    assert campaign.calibration.position_mm == pytest.approx(original.position_mm[:-2], abs=1e-6)
    assert campaign.calibration.stops.joints_rad == pytest.approx(original.stops.joints_rad[:-2], abs=1e-9)
    assert [nest.standard_uncertainty_mm for nest in campaign.nests] == [0.002] * 3
    said = capsys.readouterr().out
    assert "28 points with their joint angles" in said
    assert "(ignored): P999." in said


def test_the_day_is_kept_where_somebody_says_it_and_asked_for_where_nobody_does(exported, capsys):
    (exported / "readings.csv").write_bytes(plain())

    imported(exported, measured_on=datetime(2026, 3, 3), instrument_serial_number="T-7")
    import_command(
        exported / "readings.csv",
        out=exported / "table",
        measured_on=datetime(2026, 3, 4),
        robot_serial_number="120-1",
    )
    dated = capsys.readouterr().err
    imported(exported, "undated")

    read = [read_campaign(exported / name) for name in ("mine", "table", "undated")]
    days = [campaign.measured_on for campaign in read]
    assert [campaign.robot_serial_number for campaign in read] == ["", "120-1", ""]
    assert [campaign.instrument_serial_number for campaign in read] == ["T-7", "", ""]
    assert days == [date(2026, 3, 3), date(2026, 3, 4), None]
    assert "--measured-on" not in dated
    assert "--measured-on" in capsys.readouterr().err


def test_a_workbook_is_imported_as_its_table_is(exported):
    joints, nest, places = readings()
    numbers = np.column_stack([np.arange(len(nest)), joints, nest, places, np.full(len(nest), 0.02)])
    names = ["pose", *(f"J{k} [deg]" for k in range(1, 7)), "nest", "x [mm]", "y [mm]", "z [mm]", "u [mm]"]
    rows = [names, *(list(map(float, row)) for row in numbers)]
    (exported / "readings.xlsx").write_bytes(workbook({"Tabelle1": rows}))

    assert import_command(exported / "readings.xlsx", out=exported / "mine") == 0

    # A campaign is written with five decimals.
    assert read_campaign(exported / "mine").calibration.position_mm == pytest.approx(places, abs=1e-5)


def test_without_centres_every_nest_that_is_named_is_unknown(exported):
    imported(exported, nest=None)

    assert [nest.centre_mm for nest in read_campaign(exported / "mine").nests] == [None] * 3


def test_json_says_what_was_left_out(exported, capsys):
    imported(exported, json=True)

    told = json.loads(capsys.readouterr().out)
    assert (told["readings"], told["left_over"]) == (28, {"points": ["P999"], "lines": [30, 31]})


def test_nothing_is_written_over_and_a_centre_is_three_numbers(exported):
    imported(exported)

    with pytest.raises(ConfigurationError, match="is not empty: name another folder"):
        imported(exported)
    with pytest.raises(ConfigurationError, match="--nest 1,2: give three numbers"):
        imported(exported, out="other", nest=["1,2"])


def test_the_units_are_those_that_lists_know():
    from truepose.exchange.campaigns.point_list import UNITS_MM

    assert {unit.value for unit in LengthUnit} == set(UNITS_MM)


def test_a_table_alone_is_guessed_and_told(tmp_path, capsys):
    (tmp_path / "mine.csv").write_bytes(plain())

    assert import_command(tmp_path / "mine.csv", out=tmp_path / "mine") == 0

    assert len(read_campaign(tmp_path / "mine").calibration) == 30
    assert "Robot: ABB IRB 120, known robot with a typical error" in capsys.readouterr().err


def test_a_change_of_convention_is_made_only_where_it_is_accepted(tmp_path, capsys):
    joints, nest, places = readings()
    names = [*(f"q{k}" for k in range(1, 7)), "nest", *(f"{axis} [mm]" for axis in "xyz"), "u [mm]"]
    rows = np.column_stack([joints, nest, places / 25.4, np.full(30, 0.02)])
    (tmp_path / "mine.csv").write_bytes(table(names, rows))
    file, mine = tmp_path / "mine.csv", tmp_path / "mine"

    with pytest.raises(ConfigurationError, match="The readings fit ABB IRB 120 with this change"):
        import_command(file, out=mine, robot="abb-irb-120")
    assert import_command(file, out=mine, robot="abb-irb-120", accept_changes=True) == 0

    assert "inches" in capsys.readouterr().err
    assert read_campaign(mine).calibration.position_mm == pytest.approx(places, abs=1e-3)


def test_a_list_of_points_does_not_say_its_robot(exported):
    with pytest.raises(ConfigurationError, match="--robot"):
        imported(exported, robot=None)
