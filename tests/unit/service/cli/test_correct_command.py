"""`truepose correct`: exit status, files, and a sentence for whatever cannot be used."""

import json
from dataclasses import replace

import pytest

from tests.helpers.checkout import CHECKOUT
from tests.helpers.commands import answer, assert_one_sentence, typed
from tests.helpers.domain.robots import IRB_120
from tests.helpers.exchange.rows import read_rows
from tests.helpers.identification.models import model_of, plain_parameters, registered
from truepose.exchange.models.file import write_model

HEADER = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
NEAR = "near,350,100,400,0,0,1,0\n"
FAR = "far,9000,0,0,1,0,0,0\n"
BELOW = "below,370,60,-200,0,0,1,0\n"  # q2 = 122.5 deg, 12.5 beyond its limit


@pytest.fixture
def model(tmp_path):
    file = tmp_path / "robot.json"
    standing = model_of(IRB_120, *plain_parameters(IRB_120), base=model_of().nominal_base)
    write_model(registered(standing), file)
    return file


@pytest.fixture
def run(model, tmp_path):
    def correcting(targets, *options):
        file = tmp_path / "targets.csv"
        file.write_text(targets)
        out = tmp_path / "out.csv"
        said = typed("correct", model, file, "--out", out, *options)
        rows = read_rows(out) if out.exists() else None
        return said.returncode, rows, said

    return correcting


def test_what_is_within_reach_is_corrected(run):
    status, rows, said = run(HEADER + NEAR)

    assert status == 0
    assert [row["status"] for row in rows] == ["ok"]
    assert float(rows[0]["error_mm"]) < 1e-3
    assert said.stdout.startswith("1 of 1 targets corrected.")


def test_a_target_that_was_not_corrected_is_a_no_and_is_named(run):
    status, rows, said = run(HEADER + NEAR + FAR)

    assert status == 1
    assert [row["status"] for row in rows] == ["ok", "out_of_reach"]
    assert "far: not corrected, out of reach." in said.stdout


def test_json_counts_and_names(run):
    _, _, said = run(HEADER + NEAR + FAR, "--json")

    document = json.loads(said.stdout)
    assert document["targets"] == 2
    assert document["statuses"] == {"ok": 1, "out_of_reach": 1}
    assert document["not_corrected"] == [{"target": "far", "status": "out_of_reach"}]
    assert document["outside"] is None  # this model does not say where it was measured


def test_targets_in_the_base_go_elsewhere_than_in_the_world(run):
    _, world, _ = run(HEADER + NEAR)
    _, base, _ = run(HEADER + NEAR, "--frame", "base")

    assert abs(float(world[0]["q1_deg"]) - float(base[0]["q1_deg"])) > 1e-4


def test_half_a_table_is_never_left(run, tmp_path):
    good = HEADER + NEAR * 5000

    status, rows, said = run(good + "bad,1,2,x,1,0,0,0\n")

    assert status == 2
    assert rows is None
    assert "line 5002, column z_mm: 'x' is not a number" in said.stderr
    assert not list(tmp_path.glob("*.part"))


def test_a_file_that_is_no_model_is_refused(run, model):
    model.write_text((CHECKOUT / "README.md").read_text())

    status, rows, said = run(HEADER + NEAR)

    assert (status, rows) == (2, None)
    assert "robot.json" in said.stderr


PICTURE = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\xff"


@pytest.mark.parametrize("name", ["picture.png", "picture.mod", "picture.csv"])
def test_a_picture_is_no_robot_program_and_the_kinds_that_are_read_are_named(model, tmp_path, name):
    picture = tmp_path / name
    picture.write_bytes(PICTURE)

    done = typed("correct", model, picture, "--out", tmp_path / "out")

    kinds = ("tables (.csv)", "ABB RAPID (.mod .sys .prg)", "KUKA KRL (.src .dat)", "URScript (.script)")
    assert_one_sentence(done, f"{name}: this is a binary file, not a robot program or a table", *kinds)


def test_a_picture_in_the_place_of_a_model_is_refused_as_no_model_file(tmp_path):
    picture = tmp_path / "picture.png"
    picture.write_bytes(PICTURE)

    done = typed("correct", picture, tmp_path / "weld.mod", "--out", tmp_path / "out.mod")

    assert_one_sentence(done, "picture.png: this is not a model file")


def test_the_answer_is_given_in_french_where_that_is_asked_for(run):
    _, _, said = run(HEADER + NEAR, "--language", "fr")

    assert said.stdout.startswith("1 cibles sur 1 corrigées.")


def test_a_program_comes_back_with_other_numbers_and_what_was_left_is_said(model, tmp_path):
    rest = "[9E9,9E9,9E9,9E9,9E9,9E9]"
    text = f"MODULE M\n! by hand\nCONST jointtarget a:=[[20,30,-25,40,50,60],{rest}];\nENDMODULE\n"
    program, out = tmp_path / "m.mod", tmp_path / "out.mod"
    program.write_text(text)

    status, printed, _ = answer("correct", model, program, "--out", out)

    before, after = text.splitlines(), out.read_text().splitlines()
    assert (status, printed.splitlines()[0]) == (0, "1 of 1 targets corrected.")
    assert [k for k, pair in enumerate(zip(before, after, strict=True)) if pair[0] != pair[1]] == [2]


@pytest.mark.parametrize(
    ("option", "sentence"),
    [
        (("--define", "tGun=1,2"), "give NAME=x,y,z,qw,qx,qy,qz"),
        (("--define", "tGun=0,0,0,1,1,0,0"), "not a unit quaternion"),
        (("--branch", "left"), "name a branch such as front/up/no flip"),
    ],
)
def test_what_is_said_of_a_program_is_checked(model, tmp_path, option, sentence):
    program = tmp_path / "m.mod"
    program.write_text("MODULE M\nENDMODULE\n")

    status, _, said = answer("correct", model, program, "--out", tmp_path / "o.mod", *option)

    assert status == 2
    assert sentence in said


def test_a_program_is_never_replaced_by_its_correction(model, tmp_path):
    program = tmp_path / "a.mod"
    program.write_text("MODULE A\nENDMODULE\n")

    status, _, said = answer("correct", model, program, "--out", program)

    assert status == 2
    assert "is the targets file itself; choose another name" in said
    assert program.read_text() == "MODULE A\nENDMODULE\n"


def test_limits_that_nobody_knows_are_empty_and_said(run, tmp_path):
    unknown = replace(IRB_120, name="shop robot 7")
    standing = model_of(unknown, *plain_parameters(unknown), base=model_of().nominal_base)
    write_model(registered(standing), tmp_path / "robot.json")

    _, rows, said = run(HEADER + BELOW, "--frame", "base")

    assert [(row["status"], row["beyond_limit_deg"]) for row in rows] == [("limits_unknown", "")]
    assert float(rows[0]["q2_deg"]) == pytest.approx(122.5, abs=0.5)
    assert "The joint limits of this robot are unknown" in said.stdout


@pytest.mark.parametrize(
    "targets",
    [HEADER + BELOW, "target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\na,10,122,10,20,30,40\n"],
    ids=["pose", "joints"],
)
def test_a_target_beyond_the_limits_of_a_known_robot_is_not_corrected(run, targets):
    status, rows, _ = run(targets, "--frame", "base")

    assert status == 1
    assert (rows[0]["status"], rows[0]["q2_deg"]) == ("joint_limit", "")
    assert float(rows[0]["beyond_limit_deg"]) == pytest.approx(12.25, abs=0.5)


INCHES = HEADER + "".join(f"t{k},{x / 25.4},{y / 25.4},{z / 25.4},0,0,1,0\n" for k, (x, y, z) in enumerate([
    (350, 100, 400), (330, 150, 420), (300, -200, 450), (380, 50, 350), (360, -120, 380),
]))  # fmt: skip


def test_numbers_that_would_fit_in_inches_are_not_corrected_unless_they_are_meant_so(run):
    status, rows, said = run(INCHES)
    stated, written, _ = run(INCHES, "--as-written")

    assert (status, rows) == (1, None)
    assert "inches" in said.stderr
    assert "Nothing was written" in said.stderr
    assert (stated, len(written)) == (1 if any(row["status"] != "ok" for row in written) else 0, 5)


def test_nothing_is_written_where_nearly_all_is_out_of_reach(run):
    status, rows, said = run(HEADER + FAR * 20 + NEAR)

    assert (status, rows) == (1, None)
    assert "20 of 21 targets are out of reach: nothing was written." in said.stderr
