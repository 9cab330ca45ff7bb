"""What somebody brought, read as far as it goes: the campaign, the question, or the first wrong line."""

import json
import time
from dataclasses import replace
from datetime import date

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign
from tests.helpers.domain.robots import SEVEN_AXES
from tests.helpers.exchange.archives import zipped
from tests.helpers.identification.synthetic import leg_campaign
from tests.helpers.machine import TIME_ZONES
from tests.unit.service.exchange.import_wizard.tables import plain, readings, table
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Nest
from truepose.exchange.campaigns.folder import campaign_files
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.exchange.errors import UnsafeArchiveError
from truepose.exchange.import_wizard.column_detection import guess_columns
from truepose.exchange.import_wizard.columns import in_format
from truepose.exchange.import_wizard.dialogue import Choices, FileChoice, choices_of, merge_patch
from truepose.exchange.import_wizard.files import example_files
from truepose.exchange.import_wizard.headings import ColumnMeaning
from truepose.exchange.import_wizard.reading import read_imported_files
from truepose.exchange.import_wizard.sheet import read_sheet
from truepose.identification.verdict.conventions import Change
from truepose.messages.catalogue import english

DAY = Choices(measured_on=date(2026, 3, 3))
JOINTS = [f"q{k}" for k in range(1, 7)]
XYZ = ["x", "y", "z"]
ROBOT = replace(DAY, robot="abb-irb-120")


def whole(joints, nest, places, names=JOINTS):
    """A table without units for its places, whose uncertainty is said."""
    rows = np.column_stack([joints, nest, places, np.full(len(joints), 0.02)])
    return table([*names, "nest", *XYZ, "u [mm]"], rows)


def with_cell(line, at, cell):
    """The plain table with another text in one cell."""
    lines = plain().decode().splitlines()
    cells = lines[line - 1].split(",")
    cells[at] = cell
    lines[line - 1] = ",".join(cells)
    return "\n".join(lines).encode()


def asked(reading):
    return [question.about for question in reading.understood.questions]


def test_a_table_in_plain_words_is_a_campaign_of_the_known_robot_that_fits():
    joints, nest, places = readings()

    found = read_imported_files({"mine.csv": plain()}, DAY)

    assert found.understood.ready
    assert found.understood.robot.key == "abb-irb-120"
    assert np.degrees(found.campaign.calibration.stops.joints_rad) == pytest.approx(joints, abs=1e-4)
    assert found.campaign.calibration.position_mm == pytest.approx(places, abs=1e-4)
    assert found.campaign.calibration.nest.tolist() == nest.tolist()
    assert not found.campaign.simulated


def test_the_day_is_asked_for_and_not_guessed():
    found = read_imported_files({"mine.csv": plain()})

    assert asked(found) == ["day"]
    assert found.campaign is None


@pytest.mark.parametrize(
    ("units", "joint_size", "length_size"),
    [(("rad", "m"), np.pi / 180.0, 1e-3), (("deg", "in"), 1.0, 1.0 / 25.4), (("deg", "cm"), 1.0, 0.1)],
)
def test_units_that_are_said_are_converted(units, joint_size, length_size):
    joints, nest, places = readings()
    names = [*(f"J{k} [{units[0]}]" for k in range(1, 7)), *(f"{a} [{units[1]}]" for a in XYZ), "SMR"]
    data = table(names, np.column_stack([joints * joint_size, places * length_size, nest]))

    found = read_imported_files({"mine.csv": data}, replace(DAY, u_mm=0.02))

    assert found.campaign.calibration.position_mm == pytest.approx(places, abs=0.02)


@pytest.mark.parametrize(
    ("change", "joint_size", "length_size"),
    [("inches", 1.0, 1.0 / 25.4), ("left_handed", 1.0, np.array([1.0, -1.0, 1.0]))],
)
def test_a_change_that_makes_the_robot_fit_is_offered_and_never_made_silently(
    change, joint_size, length_size
):
    joints, nest, places = readings()
    rows = np.column_stack([joints * joint_size, nest, places * length_size, np.full(30, 0.02)])
    data = table([*JOINTS, "nest", *(f"{a} [mm]" for a in XYZ), "u [mm]"], rows)

    offered = read_imported_files({"mine.csv": data}, ROBOT)
    accepted = read_imported_files({"mine.csv": data}, replace(ROBOT, changes=(Change(change),)))

    assert asked(offered) == ["change"]
    assert offered.campaign is None
    assert [one.kind for one in offered.understood.robot.offered] == [change]
    assert accepted.campaign.calibration.position_mm == pytest.approx(places, abs=1e-3)


def test_joints_in_another_order_are_put_right_with_one_change():
    joints, nest, places = readings()
    data = whole(joints[:, [0, 2, 1, 3, 4, 5]], nest, places)

    found = read_imported_files({"mine.csv": data}, ROBOT)

    (offered,) = found.understood.robot.offered
    assert (found.understood.robot.key, offered.kind) == ("abb-irb-120", "columns")
    made = read_imported_files({"mine.csv": data}, replace(ROBOT, changes=(Change("columns", 1, 2),)))
    assert np.degrees(made.campaign.calibration.stops.joints_rad) == pytest.approx(joints, abs=1e-4)


def test_where_no_known_robot_fits_its_file_is_asked_for_and_the_description_of_a_campaign_is_one():
    joints = np.random.default_rng(1).uniform(-1.5, 1.5, (30, 7))
    data = whole(*readings(robot=SEVEN_AXES, joints=joints), names=[*JOINTS, "q7"])
    described = campaign_files(make_campaign(robot=SEVEN_AXES, nests=(Nest(None),) * 3))["campaign.json"]

    unknown = read_imported_files({"mine.csv": data}, DAY)
    known = read_imported_files({"mine.csv": data, "campaign.json": described.encode()}, DAY)

    assert asked(unknown) == ["robot"]
    assert "7 joints" in english(unknown.understood.questions[0].sentence)
    assert unknown.campaign is None
    assert known.understood.robot.key == "file"
    assert known.campaign.robot.name == "seven axes"


@pytest.mark.parametrize(
    ("name", "data", "choices", "about"),
    [
        ("letter.txt", b"Dear Ada\n", DAY, "tables"),
        ("points.csv", table(XYZ, readings()[2]), DAY, "joints"),
        ("mine.csv", plain(3), DAY, "robot"),
        ("mine.csv", table([*JOINTS, "nest", *XYZ], np.column_stack(readings())), ROBOT, "uncertainty"),
    ],
    ids=["no table", "points alone", "three places of the arm", "nothing says how uncertain it is"],
)
def test_what_nothing_says_is_asked_for(name, data, choices, about):
    assert asked(read_imported_files({name: data}, choices)) == [about]


def test_another_robot_that_somebody_insists_on_does_not_fit():
    found = read_imported_files({"mine.csv": plain()}, replace(DAY, robot="universal-robots-ur10"))

    assert asked(found) == ["robot"]
    assert not found.understood.robot.fits


def test_places_that_were_measured_again_say_how_uncertain_points_are():
    joints, nest, places = readings(10)
    rng = np.random.default_rng(0)
    again = np.vstack([places + rng.normal(scale=0.05, size=places.shape) for _ in range(8)])
    data = table([*JOINTS, "nest", *XYZ], np.column_stack([np.tile(joints, (8, 1)), np.tile(nest, 8), again]))

    found = read_imported_files({"mine.csv": data}, ROBOT)

    assert found.understood.u_mm == pytest.approx(0.05, rel=0.25)
    assert found.campaign.repeatability_in_uncertainty
    assert (found.campaign.calibration.stops.repeat_of >= 0).sum() == 70


def test_several_points_of_a_row_are_several_readings():
    joints, _, places = readings(9)
    names = [*JOINTS, *(f"a_{a}" for a in XYZ), *(f"b_{a}" for a in XYZ)]
    rows = np.column_stack([joints, places, places + np.array([10.0, 0.0, 0.0])])

    found = read_imported_files({"arm.csv": table(names, rows)}, replace(DAY, u_mm=0.02))

    assert found.understood.readings == 18
    assert found.understood.fault is None


def test_one_gross_reading_does_not_make_a_robot_look_like_another():
    joints, nest, places = readings()
    places[4, 1] += 4000.0

    found = read_imported_files({"mine.csv": whole(joints, nest, places)}, DAY)

    assert found.understood.robot.key == "abb-irb-120"


def test_a_table_named_for_checking_judges():
    found = read_imported_files({"arm.csv": plain(), "arm check.csv": plain(12)}, DAY)

    assert {file.name: file.role for file in found.understood.files} == {
        "arm.csv": "calibration",
        "arm check.csv": "validation",
    }
    assert len(found.campaign.validation) == 12


def test_of_two_tables_the_smaller_judges_and_somebody_may_say_otherwise():
    files = {"monday.csv": plain(12), "tuesday.csv": plain()}
    said = replace(DAY, files={"monday.csv": FileChoice(role="nothing")})

    assert read_imported_files(files, DAY).understood.files[0].role == "validation"
    assert read_imported_files(files, said).campaign.validation is None


def test_joints_and_points_of_two_tables_find_each_other_by_their_number():
    joints, nest, places = readings()
    order = np.random.default_rng(0).permutation(30)
    joint_table = table(["config", *JOINTS], np.column_stack([np.arange(30), joints]))
    rows = np.column_stack([np.arange(30)[order], nest[order], places[order]])
    point_table = table(["config", "nest", *XYZ], rows)

    found = read_imported_files(
        {"joints.csv": joint_table, "points.csv": point_table}, replace(ROBOT, u_mm=0.02)
    )

    assert np.degrees(found.campaign.calibration.stops.joints_rad) == pytest.approx(joints[order], abs=1e-4)


def test_lengths_are_read_and_their_robot_is_asked_for():
    legs = leg_campaign(40).legs
    rows = np.column_stack([np.degrees(legs.stops.joints_rad), legs.length_mm, np.full(40, 0.05)])
    data = table([*JOINTS, "Länge [mm]", "u [mm]"], rows)

    unnamed = read_imported_files({"wire.csv": data}, DAY)
    named = read_imported_files({"wire.csv": data}, ROBOT)

    assert asked(unnamed) == ["robot"]
    assert len(named.campaign.legs) == 40


def test_the_first_wrong_cell_is_shown_with_the_lines_around_it():
    fault = read_imported_files({"mine.csv": with_cell(15, 9, "12.3x")}, DAY).understood.fault

    assert (fault.file, fault.line, fault.column) == ("mine.csv", 15, 9)
    assert "'12.3x' is not a number" in fault.sentence
    assert [line.number for line in fault.around] == [13, 14, 15, 16, 17]
    assert fault.around[2].cells[9] == "12.3x"


def test_a_value_that_nobody_can_have_read_is_shown_where_it_was_brought():
    joints, nest, places = readings()
    places[4, 1] = 5e7

    fault = read_imported_files({"mine.csv": whole(joints, nest, places)}, DAY).understood.fault

    assert (fault.line, fault.column) == (6, 8)


@pytest.mark.parametrize("edit", [None, plain().decode().splitlines()[14]])
def test_a_wrong_line_is_corrected_or_left_out_and_the_rest_goes_on(edit):
    lines = plain().decode().splitlines()
    good = lines[14]
    lines[14] = "torn"
    wrong = read_imported_files({"mine.csv": "\n".join(lines).encode()}, DAY)
    choices = replace(DAY, files={"mine.csv": FileChoice(edits={15: edit})})

    found = read_imported_files({"mine.csv": "\n".join(lines).encode()}, choices)

    assert wrong.understood.fault.line == 15
    assert len(found.campaign.calibration) == (29 if edit is None else 30)
    assert edit in {None, good}


@pytest.mark.parametrize(
    ("nest", "said"),
    [
        ("3000000", "must be one of the tool nests: 1, 2, 3"),
        ("1e300", "too large for any quantity"),
        ("-1", "must be one of the tool nests"),
        ("1.5", "must be a whole number"),
        ("", "the cell is empty"),
    ],
)
def test_a_nest_that_nobody_has_is_shown_in_its_line_and_costs_nothing(nest, said):
    fault = read_imported_files({"mine.csv": with_cell(4, 7, nest)}, ROBOT).understood.fault

    assert (fault.line, fault.column) == (4, 7)
    assert said in fault.sentence


def test_what_a_person_says_of_a_column_counts_more_than_its_name():
    joints, nest, places = readings()
    data = table([*JOINTS, "a", "b", "c", "nest"], np.column_stack([joints, places, nest]))
    columns = {6 + k: ColumnMeaning("position", 1 + k, "mm") for k in range(3)}
    choices = replace(DAY, u_mm=0.02, files={"mine.csv": FileChoice(columns=columns)})

    assert asked(read_imported_files({"mine.csv": data}, replace(DAY, u_mm=0.02))) == ["readings"]
    assert read_imported_files({"mine.csv": data}, choices).campaign.calibration.position_mm == pytest.approx(
        places, abs=1e-4
    )


def test_a_column_that_a_person_names_outranks_one_that_is_called_so():
    joints, nest, places = readings()
    rows = np.column_stack([joints, places, places + 7.0, nest])
    data = table([*JOINTS, "a", "b", "c", *XYZ, "nest"], rows)
    columns = {6 + k: ColumnMeaning("position", 1 + k, "mm") for k in range(3)}
    choices = replace(ROBOT, u_mm=0.02, files={"mine.csv": FileChoice(columns=columns)})

    found = read_imported_files({"mine.csv": data}, choices)

    assert found.campaign.calibration.position_mm == pytest.approx(places, abs=1e-4)


def test_two_columns_that_a_person_takes_for_the_same_are_refused():
    columns = {at: ColumnMeaning("position", 1, "mm") for at in (8, 9)}
    choices = replace(ROBOT, files={"mine.csv": FileChoice(columns=columns)})

    fault = read_imported_files({"mine.csv": plain()}, choices).understood.fault

    assert (fault.file, fault.line) == ("mine.csv", 1)
    assert "two columns are assigned to this quantity" in fault.sentence


@pytest.fixture
def in_berlin(monkeypatch):
    with monkeypatch.context() as patched:
        patched.setenv("TZ", "Europe/Berlin")
        time.tzset()
        yield
    time.tzset()


@TIME_ZONES
@pytest.mark.usefixtures("in_berlin")
@pytest.mark.parametrize(
    ("times", "expected"),
    [
        (["23:59:40", "23:59:59.5", "00:00:20"], [0.0, 19.5, 40.0]),
        (["00:00:10", "23:59:50", "00:00:20"], [0.0, -20.0, 10.0]),
        (["2026-03-03T23:59:40", "2026-03-04 00:00:20", "2026-03-04T00:00:30"], [0.0, 40.0, 50.0]),
        (["2026-03-29T01:30:00", "2026-03-29T03:30:00", "2026-03-29T03:30:00+00:00"], [0.0, 7200.0, 7200.0]),
        (["0001-01-01T00:00", "0001-01-01T00:01", "0001-01-01T00:02"], [0.0, 60.0, 120.0]),
    ],
)
def test_moments_go_on_behind_midnight_and_know_no_zone_of_the_service(times, expected):
    lines = plain(3).decode().splitlines()
    text = "\n".join(f"{line},{cell}" for line, cell in zip(lines, ["time", *times], strict=True))

    found = in_format(
        sheet := read_sheet("mine.csv", text.encode()), [g.meaning for g in guess_columns(sheet)]
    )

    assert found.columns["time_s"].tolist() == expected


def test_a_campaign_folder_is_read_to_the_letter_wherever_it_lies():
    campaign = make_campaign()
    folder = {f"left arm/{name}": text.encode() for name, text in campaign_files(campaign).items()}

    assert read_imported_files(folder, DAY).campaign.nests == campaign.nests
    assert (
        read_imported_files({"mine.zip": write_campaign_zip(campaign)}, DAY).campaign.nests == campaign.nests
    )


def test_a_fault_in_a_description_is_shown_there():
    files = {name: text.encode() for name, text in campaign_files(make_campaign()).items()}
    files["campaign.json"] = files["campaign.json"].replace(b'"d_mm": 300.0', b'"d_mm": "high"', 1)

    fault = read_imported_files(files, DAY).understood.fault

    assert fault.file == "campaign.json"
    assert any('"high"' in line.text for line in fault.around)


def test_what_is_no_table_is_kept_beside_and_named():
    found = read_imported_files({"mine.csv": plain(), "photo.jpg": b"\xff\xd8\xff"}, DAY)

    assert found.understood.ready
    assert {file.name: file.kind for file in found.understood.files}["photo.jpg"] == "other"


def test_labels_of_reflectors_are_numbered_and_it_is_said():
    joints, nest, places = readings()
    lines = (
        table([*JOINTS, *XYZ, "u [mm]"], np.column_stack([joints, places, np.full(30, 0.02)]))
        .decode()
        .splitlines()
    )
    labelled = [
        f"{line},{label}" for line, label in zip(lines, ["SMR", *("ABC"[k - 1] for k in nest)], strict=True)
    ]

    found = read_imported_files({"mine.csv": "\n".join(labelled).encode()}, DAY)

    assert found.campaign.calibration.nest.tolist() == nest.tolist()
    assert any("A, B, C" in english(note) for note in found.understood.notes)


def test_the_example_says_of_itself_that_it_is_simulated():
    found = read_imported_files(example_files())

    assert found.understood.ready
    assert found.campaign.simulated
    assert found.understood.simulated


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "C:/windows/x.csv", "a/../../b.csv"])
def test_an_archive_that_leads_out_of_itself_is_refused(name):
    with pytest.raises(UnsafeArchiveError):
        read_imported_files({"mine.zip": zipped([(name, plain())])}, DAY)


def test_of_many_files_of_one_name_no_more_are_unpacked_than_are_read():
    archive = zipped([(f"{k}/points.csv", b"1") for k in range(900)])

    with pytest.raises(UnsafeArchiveError, match="upload: more than 200 files"):
        read_imported_files({f"{k}.zip": archive for k in range(5)}, DAY)


def test_archives_that_are_each_within_their_limits_are_refused_together(monkeypatch):
    monkeypatch.setattr("truepose.exchange.import_wizard.files.TOTAL_LIMIT_BYTES", 1000)

    with pytest.raises(UnsafeArchiveError, match="upload: the content exceeds"):
        read_imported_files({"a.csv": b"x" * 600, "b.csv": b"x" * 600}, DAY)


def test_an_archive_that_expands_beyond_measure_is_refused():
    archive = zipped([("mine.csv", b"0" * (8 * 2**20))])

    with pytest.raises(UnsafeArchiveError, match="expands"):
        read_imported_files({"mine.zip": archive}, DAY)


@pytest.mark.parametrize("cell", ["=1+1", "@SUM(A1)", "<script>alert(1)</script>", "1e999", "0x1F", "1_000"])
def test_a_formula_or_a_script_in_a_cell_is_no_number(cell):
    fault = read_imported_files({"mine.csv": with_cell(4, 8, cell)}, DAY).understood.fault

    assert (fault.line, fault.column) == (4, 8)


def test_a_change_of_a_joint_that_is_not_there_is_refused_in_a_sentence():
    with pytest.raises(ConfigurationError, match="undo the change"):
        read_imported_files({"mine.csv": plain()}, replace(ROBOT, changes=(Change("other_way", 8),)))


def test_what_is_said_is_merged_member_by_member():
    before = {
        "files": {"a": {"columns": {"0": {"quantity": "joint", "number": 1, "unit": "deg"}}}},
        "u_mm": 0.02,
    }

    after = merge_patch(before, {"files": {"a": {"left_out": [4], "lines": {"5": "1,2"}}}, "u_mm": None})

    assert "u_mm" not in after
    assert choices_of(json.loads(json.dumps(after))).of("a") == FileChoice(
        None, {0: ColumnMeaning("joint", 1, "deg")}, {5: "1,2", 4: None}
    )
