"""Mechanics that the library has no name for: described by where they act and what they follow.

More of them, and causes that pass for another: `tests/thorough/system/diagnosis/test_hidden_cells.py`.
"""

from tests.helpers.diagnosis.causes_without_a_name import (
    Creeping,
    Line,
    SoftFlange,
    assert_flange_told,
    assert_last_move_told,
    assert_line_told,
)
from tests.helpers.diagnosis.hidden_causes import recorded
from truepose.diagnosis.diagnose import diagnose


def test_a_line_between_whole_orders_is_told_with_its_order(tmp_path):
    assert_line_told(diagnose(recorded(tmp_path, Line(4, 12.34, 0.02), seed=3)), 4, 12.34)


def test_a_flange_that_gives_under_the_tool_is_told_by_its_load(tmp_path):
    assert_flange_told(diagnose(recorded(tmp_path, SoftFlange(2e-7, 0.0), seed=12)), 2e-7, 0.0)


def test_a_joint_that_has_not_settled_is_told_by_its_last_move(tmp_path):
    assert_last_move_told(diagnose(recorded(tmp_path, Creeping(2, 1.5e-4), seed=11)), 2, 1.5e-4)
