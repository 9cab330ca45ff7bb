import csv
import json

import numpy as np
import pytest

from tests.unit.simulators.model_documents import model_document
from truepose_simulators.errors import ReplayError
from truepose_simulators.recording.__main__ import main
from truepose_simulators.recording.measured_campaign import MeasuredTable, read_table
from truepose_simulators.recording.replay import draw_noise, stated_covariance

ROW = {
    "config": 1,
    **{f"q{joint}_deg": 0.0 for joint in range(1, 7)},
    "nest": 1,
    **dict.fromkeys(("x_mm", "y_mm", "z_mm"), 0.0),
    "u_mm": 0.02,
}
AT_ZERO_MM = [499.0, 0.0, 630.0]


class Campaign:
    """A folder with a campaign and a model, and the command that replays it."""

    def __init__(self, folder):
        self.folder, self.out = folder / "measured", folder / "out"
        self.folder.mkdir()
        self._model, self._scenario = folder / "robot.json", folder / "cell.toml"

    def write(self, role, rows, **description):
        with (self.folder / f"{role}.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
        path = self.folder / "campaign.json"
        files = json.loads(path.read_text())["files"] if path.is_file() else {}
        document = {"format": 1, "files": {**files, role: f"{role}.csv"}, **description}
        path.write_text(json.dumps(document))

    def replay(self, *parameters, noise=False, seed=0, **changes):
        self._model.write_text(json.dumps(model_document(*parameters, **changes)))
        self._scenario.write_text(f'extends = "irb120-clean"\nnoise = {str(noise).lower()}\n')
        arguments = [str(self._scenario), "--model", str(self._model), "--seed", str(seed)]
        return main([*arguments, "--replay", str(self.folder), "--out", str(self.out)])

    def column(self, role, *names):
        with (self.out / f"{role}.csv").open() as file:
            return np.array([[float(row[name]) for name in names] for row in csv.DictReader(file)])

    def positions(self, role="calibration"):
        return self.column(role, "x_mm", "y_mm", "z_mm")


@pytest.fixture
def campaign(tmp_path):
    return Campaign(tmp_path)


def table(**columns):
    return MeasuredTable("rows.csv", {name: [str(v) for v in values] for name, values in columns.items()})


def test_only_the_positions_are_others_than_measured(campaign):
    campaign.write("calibration", [{**ROW, "config": 7, "remark": "left door open", "group": 3}])

    assert campaign.replay() == 0

    assert campaign.positions() == pytest.approx(np.array([AT_ZERO_MM]), abs=1e-5)
    with (campaign.out / "calibration.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["config"], row["remark"], row["group"], row["u_mm"]) == ("7", "left door open", "3", "0.02")


def test_orientations_are_left_out_because_this_tracker_reads_points(campaign):
    campaign.write("calibration", [{**ROW, "qw": 1, "qx": 0, "qy": 0, "qz": 0, "u_rot_deg": 0.1}])

    campaign.replay()

    with (campaign.out / "calibration.csv").open() as file:
        assert list(csv.DictReader(file).fieldnames) == list(ROW)


def test_the_description_stays_and_says_that_it_is_a_replay(campaign):
    campaign.write("calibration", [ROW], robot="ours", notes=["first"], measured_on="2026-03-03")

    campaign.replay()

    document = json.loads((campaign.out / "campaign.json").read_text())
    assert document["robot"] == "ours"
    assert document["simulated"] is True
    assert "measured_on" not in document  # that day was another one's
    assert document["notes"][0] == "first"
    assert "Replayed in the simulated cell" in document["notes"][1]
    truth = json.loads((campaign.out / "truth.json").read_text())
    assert truth["true_positions_mm"]["calibration"] == [pytest.approx(AT_ZERO_MM)]


def test_fixed_nests_are_read_through_the_same_drifting_tracker(campaign):
    fixed = {"fixed_nest": 2, "x_mm": 1, "y_mm": 2, "z_mm": 3, "u_mm": 0.01}
    certified = [[0, 0, 0], [600.0, 500.0, 0.0]]
    campaign.write("calibration", [{**ROW, "time_s": 3700.0}])
    campaign.write(
        "reference",
        [{**fixed, "time_s": 100.0}, {**fixed, "time_s": 3700.0}],
        fixed_nests_certified_mm=certified,
    )

    campaign.replay(("instrument_drift", "tracker_linear_x", 0.5, "mm/h"), origin_s=100.0)

    assert campaign.positions("reference") == pytest.approx(
        np.array([[600.0, 500.0, 0.0], [600.5, 500.0, 0.0]]), abs=1e-5
    )
    assert campaign.positions()[0] == pytest.approx(np.add(AT_ZERO_MM, [0.5, 0, 0]), abs=1e-5)


def test_fixed_nests_stand_where_the_model_found_them(campaign):
    fixed = {"time_s": 0.0, "fixed_nest": 1, "x_mm": 1, "y_mm": 2, "z_mm": 3, "u_mm": 0.01}
    campaign.write("calibration", [ROW])
    campaign.write("reference", [fixed], fixed_nests_certified_mm=[[1000.0, 0.0, 0.0]])

    found = [("reference", "fixed_1_x", 0.2, "mm"), ("reference", "frame_z", 0.1, "mm")]
    campaign.replay(*found, ("reference", "frame_rz", 1e-3, "rad"))

    expected = [1000.2 * np.cos(1e-3), 1000.2 * np.sin(1e-3), 0.1]
    assert campaign.positions("reference")[0] == pytest.approx(expected, abs=1e-5)
    assert campaign.positions()[0] == pytest.approx(AT_ZERO_MM, abs=1e-5)  # the arm's base took it already


def test_fixed_nests_without_certificate_are_where_they_were_read_on_average(campaign):
    fixed = {"time_s": 0.0, "fixed_nest": 1, "y_mm": 2, "z_mm": 3, "u_mm": 0.01}
    campaign.write("calibration", [ROW])
    campaign.write("reference", [{**fixed, "x_mm": 1.0}, {**fixed, "x_mm": 2.0}])

    campaign.replay()

    assert campaign.positions("reference") == pytest.approx(np.array([[1.5, 2.0, 3.0]] * 2), abs=1e-5)


def test_sensed_torques_wind_up_the_springs_in_the_place_of_gravity(campaign):
    torques = {f"tau{joint}_Nm": 100.0 if joint == 1 else 0.0 for joint in range(1, 7)}
    campaign.write("calibration", [{**ROW, **torques}])

    campaign.replay(("compliance", "c_1", 1e-8, "rad/(N*mm)"), torques_measured=True)

    # 100 N m are 1e5 N mm: 1e-3 rad on a lever of 499 mm.
    assert campaign.positions()[0, 1] == pytest.approx(499.0 * np.sin(1e-3), abs=1e-5)


def test_noise_is_what_the_campaign_states_and_scatter_is_the_same_in_one_configuration(campaign):
    rows = [{**ROW, "config": k // 2, "u_mm": 0.0001} for k in range(800)]
    campaign.write("calibration", rows)

    campaign.replay(noise=True, repeatability_mm=0.05)

    off = campaign.positions() - AT_ZERO_MM
    pairs = off.reshape(400, 2, 3)
    assert np.abs(pairs[:, 0] - pairs[:, 1]).max() < 0.001  # two readings of 0.0001 mm, seven deviations
    # 1,200 values: their standard deviation is known to 2 %, four of these.
    assert pairs[:, 0].std() == pytest.approx(0.05, rel=0.08)


def test_scatter_that_the_stated_uncertainty_contains_is_not_added_again(campaign):
    campaign.write(
        "calibration", [{**ROW, "config": k, "u_mm": 0.01} for k in range(400)], u_includes_repeatability=True
    )

    campaign.replay(noise=True, repeatability_mm=5.0)

    assert (campaign.positions() - AT_ZERO_MM).std() == pytest.approx(0.01, rel=0.08)


def test_the_seed_decides_the_noise(campaign):
    campaign.write("calibration", [ROW])

    first, again, other = [
        (campaign.replay(noise=True, seed=seed), campaign.positions())[1] for seed in (1, 1, 2)
    ]

    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_an_effect_that_the_rows_do_not_tell_enough_for_is_said(campaign, capsys):
    campaign.write("calibration", [ROW])

    drift = ("base_drift", "drift_linear_x", 1.0, "mm/h")
    assert campaign.replay(drift, ("backlash", "gap_1", 0.01, "deg"), origin_s=1e6) == 0

    assert capsys.readouterr().err.splitlines() == [
        "calibration.csv has no column dir1: backlash does not act in its rows",
        "calibration.csv has no column time_s: base_drift does not act in its rows",
    ]
    assert campaign.positions() == pytest.approx(np.array([AT_ZERO_MM]), abs=1e-5)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"q6_deg": None}, "calibration.csv has 5 columns q<joint>_deg, the robot of the model has 6 joints"),
        ({"q7_deg": 1.0}, "has 7 columns q<joint>_deg, the robot of the model has 6 joints"),
        ({"nest": 2}, "line 2: the model has nests 1 to 1, not 2"),
        ({"nest": 0.5}, "line 2: the model has nests 1 to 1, not 0.5"),
        ({"nest": None}, "has no column nest, which a replay needs"),
        ({"q2_deg": ""}, "line 2: q2_deg is empty, which a replay needs"),
        ({"q2_deg": "ten"}, 'line 2: q2_deg must be a finite number, not "ten"'),
        ({"time_s": "inf"}, 'line 2: time_s must be a finite number, not "inf"'),
        ({"config": None}, "has no column config"),
    ],
)
def test_rows_that_cannot_be_replayed_are_refused_with_line_and_column(campaign, capsys, change, sentence):
    row = {name: value for name, value in {**ROW, **change}.items() if value is not None}
    campaign.write("calibration", [row])

    assert campaign.replay(noise=True) == 2

    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not campaign.out.exists()


def test_springs_of_sensed_torques_need_them_where_no_mass_is_stated(campaign, capsys):
    campaign.write("calibration", [ROW])
    robot = {**model_document()["robot"], "masses": []}

    assert campaign.replay(torques_measured=True, robot=robot) == 2

    assert "has 0 columns tau<joint>_Nm, the robot of the model has 6 joints" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        ({"legs": "legs.csv"}, '"legs" of key "files" cannot be replayed: only a laser tracker'),
        ({}, 'key "files" must name the tables of the campaign'),
        ({"calibration": "../secret.csv"}, "must name a CSV file of the folder"),
        ({"calibration": "gone.csv"}, "cannot be read: No such file"),
    ],
)
def test_campaigns_that_no_tracker_measured_are_refused(campaign, capsys, files, sentence):
    campaign.write("calibration", [ROW], files=files)

    assert campaign.replay() == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "has no rows"),
        (b"config\n", "has no rows"),
        (b"config,nest\n1\n", "line 2: 1 cells, but the header has 2"),
        (b"config\n\xff\n", "not a CSV table in UTF-8"),
    ],
)
def test_tables_that_are_none_are_refused(tmp_path, content, sentence):
    (tmp_path / "rows.csv").write_bytes(content)

    with pytest.raises(ReplayError, match=sentence):
        read_table(tmp_path / "rows.csv")


def test_a_description_that_is_no_json_is_refused(campaign, capsys):
    campaign.write("calibration", [ROW])
    (campaign.folder / "campaign.json").write_text("[")

    assert campaign.replay() == 2
    assert "campaign.json is not JSON" in capsys.readouterr().err


def test_the_measured_campaign_is_never_written_over(campaign, capsys):
    campaign.write("calibration", [ROW])
    campaign.out = campaign.folder / ".." / "measured"

    assert campaign.replay() == 2
    assert "is the measured campaign itself; choose another folder" in capsys.readouterr().err


def test_a_replay_without_a_model_is_refused(campaign, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["irb120-clean", "--replay", str(campaign.folder), "--out", str(campaign.out)])

    assert ended.value.code == 2
    assert "also give the model of that robot, with --model" in capsys.readouterr().err


def test_deviations_along_and_across_the_beam_count_where_a_row_has_them():
    rows = table(u_mm=[0.5, 0.5], u_along_mm=[0.1, ""], u_across_mm=[0.3, ""])
    beam = np.array([[1000.0, 0.0, 0.0], [0.0, 1000.0, 0.0]])

    covariance = stated_covariance(rows, beam, np.zeros(3))

    assert covariance[0] == pytest.approx(np.diag([0.01, 0.09, 0.09]))
    assert covariance[1] == pytest.approx(0.25 * np.eye(3))


def test_a_full_covariance_counts_most():
    stated = {"cxx": 4.0, "cxy": 1.0, "cxz": 0.0, "cyy": 2.0, "cyz": 0.5, "czz": 1.0}
    rows = table(u_mm=[9.0], **{name: [value] for name, value in stated.items()})

    covariance = stated_covariance(rows, np.ones((1, 3)), np.zeros(3))

    assert covariance[0] == pytest.approx(np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.5], [0.0, 0.5, 1.0]]))


def test_drawn_noise_has_the_stated_covariance():
    n = 4000
    stated = {"cxx": 4.0, "cxy": 1.0, "cxz": 0.0, "cyy": 2.0, "cyz": 0.5, "czz": 1.0}
    rows = table(u_mm=[9.0] * n, **{name: [value] * n for name, value in stated.items()})

    noise = draw_noise(rows, np.ones((n, 3)), np.zeros(3), np.random.default_rng(0))

    # An entry of a covariance of n draws is known to sqrt(2 / n) of its diagonal, 2 %, four of these.
    assert np.cov(noise.T) == pytest.approx(
        np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.5], [0.0, 0.5, 1.0]]), abs=0.09 * 4.0
    )
