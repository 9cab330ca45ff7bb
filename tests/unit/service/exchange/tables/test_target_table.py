"""Tables of targets: what is read of them, and what is written of their corrections."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from truepose.correction import ANY_BRANCH, FLANGE, correct
from truepose.domain.robot import JointRange
from truepose.exchange.errors import BadValueError, MissingEntryError, UnreadableFileError
from truepose.exchange.tables.targets import CorrectionWriter, targets_of

POSE = "300,0,500,1,0,0,0"
HEADER = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz"
JOINTS = "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg"
ROOMY = replace(IRB_120, joint_limits=(JointRange(-3.2, 3.2),) * 6)
MODEL = model_of(ROOMY, base=model_of().nominal_base)


def read(text):
    return list(targets_of("targets.csv", text.encode(), 6, [1, 2]))


def one(text):
    (part,) = read(text)
    return part


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (f'{HEADER}\n"weld, left",{POSE}\np 2,{POSE}\n', ("weld, left", "p 2")),
        ("x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + f"{POSE}\n" * 3, ("1", "2", "3")),
    ],
    ids=["given", "numbered from one"],
)
def test_names_stay_as_they_stood_commas_included(text, names):
    assert one(text).names == names


def test_only_the_pose_must_be_there():
    part = one(f"{HEADER}\na,1,2,3,0.5,0.5,0.5,0.5\n")

    assert part.poses.position_mm.tolist() == [[1.0, 2.0, 3.0]]
    assert part.poses.rotation[0] == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]), abs=1e-15)
    assert part.poses.nest.tolist() == [FLANGE]
    assert part.branch.tolist() == [ANY_BRANCH]
    assert np.isnan(part.stops.joints_rad).all()


def test_branch_nest_joints_and_stop_are_taken_where_they_stand():
    header = f"{HEADER},branch,nest,{JOINTS},dir1,dir2,dir3,dir4,dir5,dir6"
    part = one(
        f"{header},temperature_C\na,{POSE},back/up/flip,2,10,20,30,40,50,60,1,1,1,1,1,-1,23.5\n"
        f"b,{POSE},,,,,,,,,,,,,,,\nc,{POSE},3,0,,,,,,,,,,,,,\n"
    )

    assert part.branch.tolist() == [5, ANY_BRANCH, 3]
    assert part.poses.nest.tolist() == [2, FLANGE, FLANGE]
    assert np.degrees(part.stops.joints_rad[0]) == pytest.approx([10, 20, 30, 40, 50, 60])
    assert np.isnan(part.stops.joints_rad[1:]).all()
    assert part.stops.direction[0].tolist() == [1, 1, 1, 1, 1, -1]
    assert part.stops.temperature_c[0] == 23.5


def test_a_long_table_comes_in_parts_that_are_numbered_on():
    parts = read(f"{HEADER}\n" + "".join(f"p{k},{POSE}\n" for k in range(9000)))

    assert len(parts) > 1
    assert [name for part in parts for name in part.names] == [f"p{k}" for k in range(9000)]
    assert np.concatenate([part.stops.config for part in parts]).tolist() == list(range(9000))
    assert parts[-1].share == 1.0


@pytest.mark.parametrize(
    ("text", "error", "sentence"),
    [
        ("target,x_mm,y_mm,z_mm\na,1,2,3\n", MissingEntryError, "column qw is missing"),
        (f"{HEADER}\na,1,2,3,2,0,0,0\n", BadValueError, r"line 2, column qw: .*unit quaternion"),
        (f"{HEADER},branch\na,{POSE},left\n", BadValueError, r"line 2, column branch: 'left' must be"),
        (f"{HEADER},nest\na,{POSE},3\n", BadValueError, r"line 2, column nest: .*0, 1, 2"),
        (f"{HEADER},q1_deg\na,{POSE},1\n", MissingEntryError, "q2_deg is missing"),
        (
            f"{HEADER},{JOINTS}\na,{POSE},1,2,,4,5,6\n",
            BadValueError,
            r"line 2, column q1_deg: some joints are given and some are empty",
        ),
        (f"{HEADER}\n", UnreadableFileError, "no rows"),
        (HEADER.replace("x_mm", "x_m") + f"\na,{POSE}\n", Exception, "x_m"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(text, error, sentence):
    with pytest.raises(error, match=sentence):
        read(text)


def test_a_table_of_joints_alone_is_what_the_controller_would_be_sent_to():
    part = one(f"{JOINTS}\n10,20,30,40,50,60\n")

    assert part.poses is None
    assert np.degrees(part.stops.joints_rad) == pytest.approx(np.array([[10, 20, 30, 40, 50, 60]]))


def test_a_table_of_joints_alone_has_all_of_them():
    with pytest.raises(BadValueError, match=r"line 2, column q3_deg: the cell is empty"):
        read(f"{JOINTS}\n10,20,,40,50,60\n")


def test_a_table_of_more_targets_than_are_wanted_is_refused():
    with pytest.raises(UnreadableFileError, match="more than 2 rows"):
        list(targets_of("t.csv", (f"{HEADER}\n" + f"a,{POSE}\n" * 3).encode(), 6, [1, 2], 2))


def test_columns_of_the_file_that_the_answer_does_not_have_stand_behind_it():
    part = one(f'{HEADER},note,status\na,{POSE},"fast, then ""slow""",old\n')
    found = correct(MODEL, part.poses, part.branch)
    stream = io.StringIO()

    CorrectionWriter(stream).write(part.names, found, part.own)

    (row,) = csv.DictReader(io.StringIO(stream.getvalue()))
    assert (row["target"], row["x_mm"], row["note"]) == ("a", "300", 'fast, then "slow"')
    assert row["status"] == "ok"
    assert list(row)[-8:] == ["x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "note"]


def test_what_is_written_keeps_the_order_and_leaves_out_joints_that_do_not_lead_there():
    part = one(f'{HEADER}\n"a, b",{POSE}\nfar,9000,0,500,1,0,0,0\n')
    found = correct(MODEL, part.poses, part.branch)
    stream = io.StringIO()
    writer = CorrectionWriter(stream)

    writer.write(part.names, found)
    writer.write(part.names, found)

    rows = list(csv.DictReader(io.StringIO(stream.getvalue())))
    assert [row["target"] for row in rows] == ["a, b", "far"] * 2
    assert list(rows[0])[:8] == ["target", "branch", *JOINTS.split(",")]
    assert [row["status"] for row in rows[:2]] == ["ok", "out_of_reach"]
    joints = np.radians([float(rows[0][f"q{j}_deg"]) for j in range(1, 7)])
    assert joints == pytest.approx(found.joints_rad[0], abs=1e-11)
    assert rows[1]["q1_deg"] == rows[1]["branch"] == rows[1]["u_mm"] == ""
    assert float(rows[1]["error_mm"]) > 1000.0
