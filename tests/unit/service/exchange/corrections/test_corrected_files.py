"""Files of targets corrected: whatever they are, and of whose robot."""

import io
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from truepose.correction import pose_shifts
from truepose.domain.errors import ConfigurationError
from truepose.exchange.corrections import check_file, correct_file
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.programs.correction_request import CorrectionRequest, branch_named, frame_defined
from truepose.exchange.programs.program import TargetConventions
from truepose.kinematics.chain import nominal_chain

REST = "[9E9,9E9,9E9,9E9,9E9,9E9]"
JOINTS = [20.0, 30.0, -25.0, 40.0, 50.0, 60.0]
MODULE = f"MODULE M\nCONST jointtarget a:=[{JOINTS},{REST}];\nENDMODULE\n".encode()
TABLE = b"target,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,note\na,20,30,-25,40,50,60,first\n"


def model(robot=IRB_120):
    plain = model_of(robot, *plain_parameters(IRB_120))
    return replace(plain, nominal_base=plain.base)


_AS_IT_IS = CorrectionRequest()


def corrected(name, data, asked=_AS_IT_IS):
    out, seen = io.BytesIO(), []
    answer = correct_file(model(), name, data, asked, out, seen.append)
    return answer, out.getvalue(), seen


def test_joints_in_a_table_and_in_a_program_are_the_same_target():
    _, text, (of_table,) = corrected("a.csv", TABLE)
    _, again, (of_program,) = corrected("a.mod", MODULE)

    assert of_table.found.joints_rad == pytest.approx(of_program.found.joints_rad, abs=1e-12)
    assert text.splitlines()[1].endswith(b",first")
    assert again != MODULE
    assert (of_table.lines.tolist(), of_program.lines.tolist()) == ([2], [2])


def test_joints_mean_the_same_place_whatever_poses_are_given_in():
    _, world, _ = corrected("a.csv", TABLE, CorrectionRequest(TargetConventions.WORLD))
    _, base, _ = corrected("a.csv", TABLE, CorrectionRequest(TargetConventions.BASE))

    assert world == base


def test_the_shift_leads_from_the_place_meant_to_where_the_controller_believes_to_be():
    _, _, (rows,) = corrected("a.csv", TABLE)

    place, shift = pose_shifts(model(), rows.goals, rows.found.joints_rad)

    meant = nominal_chain(IRB_120, np.radians([JOINTS])).end_origin
    sent = nominal_chain(IRB_120, rows.found.joints_rad).end_origin
    assert place == pytest.approx(meant, abs=1e-9)
    assert place + shift == pytest.approx(sent, abs=1e-9)
    assert 0.1 < np.linalg.norm(shift) < 10.0


@pytest.mark.parametrize(("name", "data"), [("a.csv", TABLE), ("a.mod", MODULE)])
def test_a_file_that_can_be_corrected_is_counted(name, data):
    assert check_file(model(), name, data, CorrectionRequest()) == 1


@pytest.mark.parametrize(("name", "data"), [("a.csv", TABLE), ("a.mod", MODULE)])
def test_more_targets_than_are_taken_are_refused(name, data):
    with pytest.raises(UnreadableFileError, match="has more than 0"):
        check_file(model(), name, data, CorrectionRequest(most_targets=0))


def test_a_program_of_another_maker_is_refused_and_one_for_a_robot_of_any_name_is_not():
    fanuc = model(replace(IRB_120, name="Fanuc LR Mate 200iC"))

    with pytest.raises(ConfigurationError, match="for ABB robots, but the model is of Fanuc"):
        check_file(fanuc, "a.mod", MODULE, CorrectionRequest())
    assert check_file(fanuc, "a.csv", TABLE, CorrectionRequest()) == 1
    assert check_file(model(replace(IRB_120, name="left arm")), "a.mod", MODULE, CorrectionRequest()) == 1


def test_what_is_said_beside_the_file_is_read():
    assert branch_named("back/down/flip", "branch") == 7
    assert frame_defined("tGun=1,2,3,1,0,0,0", "define")[1].position_mm == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("numbers", ["1,2", "1,2,3,2,0,0,0", "nan,2,3,1,0,0,0", "1,2,3,nan,0,0,0"])
def test_a_frame_that_is_none_is_refused(numbers):
    with pytest.raises(ConfigurationError, match="define tGun"):
        frame_defined(f"tGun={numbers}", "define")
