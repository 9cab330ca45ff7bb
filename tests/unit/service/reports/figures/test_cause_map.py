"""The map of a diagnosis: what is told where, how much of it, and where rivals would act."""

import re
import xml.etree.ElementTree as ElementTree

import pytest

from tests.helpers.diagnosis.answers import make_described, make_diagnosis, make_finding, make_rest, make_wave
from truepose.domain.diagnosis import Cause, EffectSize
from truepose.reports.diagnosis.cause_map import cause_map, map_picture, share_text

COUPLED = Cause("unnamed", "joint 4, angle of joint 2, line")


def wave(joint, own_mm, *rivals):
    """A wave of a joint's own angle."""
    return make_wave(
        subject=f"joint {joint}",
        where=f"joint {joint}",
        over=f"angle of joint {joint}",
        worth=EffectSize(9.0, 9.0, own_mm),
        confusable_with=rivals,
    )


def described(where, over, own_mm):
    return make_described(where=where, over=over, worth=EffectSize(9.0, 9.0, own_mm))


def mapped(*findings, small=(), rest=()):
    return cause_map(make_diagnosis(findings=findings, small=small, remaining=make_rest(*rest)))


def at(found, where, over):
    (cell,) = [cell for cell in found.cells if cell.place == (where, over)]
    return cell


def test_shares_are_those_of_squares_of_what_only_this_explains():
    found = mapped(wave(2, 0.3), rest=[described("joint 1", "angle of joint 2", 0.1)])

    assert at(found, "joint 2", "angle of joint 2").share == pytest.approx(0.9)
    assert at(found, "joint 1", "angle of joint 2").share == pytest.approx(0.1)


def test_findings_carry_their_numbers_and_share_a_cell_with_what_is_described_there():
    more = described("joint 2", "angle of joint 2", 0.3)

    found = mapped(wave(6, 0.4), wave(2, 0.2), small=(wave(2, 0.1),), rest=[more])

    cell = at(found, "joint 2", "angle of joint 2")
    assert cell.findings == (2, 3)
    assert cell.share == pytest.approx(0.14 / 0.30)
    assert at(found, "joint 6", "angle of joint 6").findings == (1,)


def test_a_rival_is_where_it_would_act_and_has_no_share():
    found = mapped(wave(2, 0.3, COUPLED, Cause("joint_gain", "joint 2")))

    rival = at(found, "joint 4", "angle of joint 2")
    assert (rival.share, rival.findings, rival.rival_of) == (0.0, (), (1,))
    assert found.links == ((("joint 2", "angle of joint 2"), rival.place),)  # a gain acts in the same cell


@pytest.mark.parametrize("rival", [Cause("joint_coupling", "joint 4"), Cause("of_a_package_gone", "base")])
def test_a_rival_whose_name_does_not_tell_its_place_is_left_out(rival):
    assert mapped(wave(2, 0.3, rival)) is None
    assert mapped(wave(2, 0.3, rival), wave(3, 0.3)).links == ()


def test_rows_go_along_the_arm_and_columns_from_its_own_variables_outwards():
    rest = [
        described("nest 2", "constant", 0.1),
        described("joint 10", "time", 0.1),
        described("base", "load", 0.1),
        described("joint 9", "angle of joint 1", 0.1),
    ]

    found = mapped(rest=rest)

    assert found.rows == ("base", "joint 9", "joint 10", "nest 2")
    assert found.columns == ("angle of joint 1", "load", "time", "constant")


def test_what_is_wrong_with_readings_moves_no_tool():
    bad = make_finding(effect="outliers", subject="readings", where="readings", over="constant", worth=None)

    found = mapped(bad, wave(2, 0.3), wave(3, 0.3))

    assert found.rows == ("joint 2", "joint 3")
    assert at(found, "joint 2", "angle of joint 2").findings == (2,)


def test_an_earlier_diagnosis_is_mapped_by_how_far_its_causes_move_the_tool():
    first, second = (
        make_wave(where=f"joint {k}", over="time", worth=EffectSize(0.1 * k, 0.9)) for k in (1, 3)
    )

    assert at(mapped(first, second), "joint 3", "time").share == pytest.approx(0.9)


def test_there_is_no_map_of_nothing_nor_of_a_single_cell():
    assert mapped() is None
    assert mapped(make_finding()) is None  # of before findings said where they act
    assert mapped(wave(2, 0.3), wave(2, 0.1)) is None


def test_the_picture_says_shares_and_numbers_in_words():
    svg = map_picture(mapped(wave(2, 0.3, COUPLED), rest=[described("joint 1", "load", 0.02)]))

    texts = {
        "".join(text.itertext()).strip() for text in ElementTree.fromstring(svg).iter() if "text" in text.tag
    }
    assert {"(1) 100 %", "< 1 %", "joint 1", "joint 4", "angle of joint 2", "load"} <= texts
    assert {"modelled empirically", "location of an alternative explanation"} <= texts
    assert not re.search(r"#0[1-9a]0[1-9a]0[1-9a]", svg)


def test_a_legend_names_only_what_is_drawn():
    svg = map_picture(mapped(wave(2, 0.3), wave(3, 0.3)))

    assert "finding, with its number" in svg
    assert "rival" not in svg
    assert "described" not in svg


@pytest.mark.parametrize(("share", "text"), [(0.0, ""), (0.004, "< 1 %"), (0.126, "13 %"), (1.0, "100 %")])
def test_a_share_is_in_per_cent(share, text):
    assert share_text(share) == text
