"""`truepose plan` as a shop calls it: document, table, status, sentences."""

import csv
import json
import shutil

import pytest

from tests.helpers.commands import installed, typed


def plan(*arguments, status=0, run=typed):
    done = run("plan", *arguments)
    assert done.returncode == status, done.stderr
    return done


def test_the_document_has_what_programs_rely_on(tmp_path):
    out = tmp_path / "plan.csv"

    document = json.loads(plan("abb-irb-120", "--n", "25", "--json", "--out", str(out), run=installed).stdout)

    assert len(document["configurations_deg"]) == len(document["nests"]) == document["n"] == 25
    point = next(point for point in document["predicted"] if point["n"] == 25)
    low, high = point["interval_90_mm"]
    assert 0.0 < low < point["mean_mm"] < high < point["worst_mm"]
    assert document["open"] == []
    assert set(document["observability"]) == {"O1", "O2", "O3", "O4", "O5"}
    assert document["minutes"] > 3.0
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert [float(row["q1_deg"]) for row in rows] == pytest.approx([
        joints[0] for joints in document["configurations_deg"]
    ])


def test_parameters_that_a_plan_cannot_determine_are_named_with_status_1():
    document = json.loads(plan("abb-irb-120", "--n", "4", "--json", status=1).stdout)

    assert any("c_5" in group["parameters"] for group in document["open"])
    assert all(group["reason"] for group in document["open"])


def test_a_plan_of_a_closed_loop_says_what_is_read_at_each_stop(tmp_path):
    (tmp_path / "targets.csv").write_text("target,kind,x_mm,y_mm,z_mm\n4,ball,430,0,260\n")
    out = tmp_path / "plan.csv"

    loop = ("--targets", str(tmp_path / "targets.csv"), "--nests", "2", "--reading-mm", "0.01")
    document = json.loads(plan("lrmate-tilted", *loop, "--n", "30", "--json", "--out", str(out)).stdout)

    assert document["instrument"] == "closed loop"
    assert document["targets"] == [[4]] * 30
    assert document["nests"] == [2] * 30
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert {row["targets"] for row in rows} == {"4"}


def test_a_ballbar_plan_has_legs_and_cups():
    document = json.loads(plan("irb120-tilted", "--ballbar", "--n", "20", "--json").stdout)

    assert document["instrument"] == "ballbar"
    assert all(len(legs) == 6 for legs in document["legs"])
    assert len(document["placements"][0]["cups_mm"]) == 3


def test_people_read_the_promise_its_knee_and_what_it_rests_on():
    printed = plan("abb-irb-120").stdout

    assert "Predicted mean error with" in printed
    assert "The knee of the curve is at" in printed
    assert "the parameters describe the arm completely" in printed


def test_a_campaign_goes_on_from_what_was_measured():
    document = json.loads(plan("docs/examples/campaign", "--n", "10", "--json").stdout)

    assert document["measured"] == 30
    assert document["n"] == 40
    assert len(document["configurations_deg"]) == 10


def test_a_campaign_that_is_too_small_for_a_model_promises_nothing(tmp_path):
    folder = tmp_path / "few"
    shutil.copytree("docs/examples/campaign", folder)
    table = folder / "calibration.csv"
    table.write_text("".join(table.read_text().splitlines(keepends=True)[:3]))

    assert "No accuracy can be predicted" in plan(str(folder), status=2).stderr


@pytest.mark.parametrize("instrument", ["tracker", "closed loop"])
def test_a_cell_whose_tool_has_no_nest_has_no_plan(tmp_path, instrument):
    cell = tmp_path / "cell.toml"
    cell.write_text('robot = "kuka-kr-6-r900-sixx"\n[[device]]\nname = "tracker"\ndriver = "leica_emscon"\n')
    (tmp_path / "targets.csv").write_text("target,kind,x_mm,y_mm,z_mm\n1,ball,430,0,260\n")
    loop = ("--targets", str(tmp_path / "targets.csv")) if instrument == "closed loop" else ()

    assert "no tool nest" in plan(str(cell), *loop, "--n", "6", status=2).stderr


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("robbie",), "is not a campaign folder, cell file, robot file or robot name"),
        (("abb-irb-120", "--volume", "none.toml"), "none.toml"),
        (("abb-irb-120", "--reading-mm", "-1"), "--reading-mm -1"),
        (("docs/examples/campaign", "--ballbar"), "not for a campaign"),
        (("abb-irb-120", "--nests", "1"), "give --targets as well"),
    ],
)
def test_unusable_input_is_one_sentence(arguments, sentence):
    done = plan(*arguments, status=2)

    assert sentence in done.stderr
    assert done.stdout == ""
