"""What the format leaves open in a table is read as it means."""

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign, make_points
from truepose.exchange.campaigns.folder import campaign_files, campaign_from
from truepose.messages.catalogue import english

HEADER = "config,q1_deg,q2_deg,q3_deg,nest,x_mm,y_mm,z_mm,u_mm"
ROWS = ("1,0,10,20,1,100,200,300,0.02", "2,5,15,25,1,110,210,310,0.03")


def read(text, **changes):
    files = {name: content.encode() for name, content in campaign_files(make_campaign(**changes)).items()}
    data = text if isinstance(text, bytes) else text.encode()
    return campaign_from({**files, "calibration.csv": data}.__getitem__)


def with_columns(names, *cells):
    rows = [f"{row},{cell}" for row, cell in zip(ROWS, cells, strict=True)]
    return "\n".join([f"{HEADER},{names}", *rows])


PLAIN = "\n".join([HEADER, *ROWS])


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.encode(),
        PLAIN.encode("utf-8-sig"),
        PLAIN.replace("\n", "\r\n").encode(),
        PLAIN.replace(",", " , ").encode(),
        (PLAIN + "\n\n\n").encode(),
        PLAIN.replace("config", '"config"').encode(),
        PLAIN.replace("\n1,", "\n1.0,").encode(),
        PLAIN.replace("0.03", "+3.e-2").encode(),
    ],
    ids=["plain", "bom", "crlf", "blanks", "blank lines", "quotes", "1.0 for 1", "exponent"],
)
def test_the_ways_of_programs_to_write_csv_make_no_difference(text):
    points = read(text).calibration

    assert points.stops.config.tolist() == [1, 2]
    assert points.position_mm.tolist() == [[100.0, 200.0, 300.0], [110.0, 210.0, 310.0]]
    assert points.standard_uncertainty_mm.tolist() == [0.02, 0.03]


def test_columns_come_in_any_order():
    swapped = "\n".join(",".join(reversed(line.split(","))) for line in PLAIN.splitlines())

    points = read(swapped).calibration

    assert points.position_mm[1].tolist() == [110.0, 210.0, 310.0]
    assert np.degrees(points.stops.joints_rad[1]) == pytest.approx([5.0, 15.0, 25.0], rel=1e-15)


def test_absent_columns_are_unknown():
    points = read(PLAIN).calibration

    stops = points.stops
    unknown = (stops.direction, stops.time_s, stops.temperature_c, stops.attachment, stops.torque_n_mm)
    assert (*unknown, stops.group, stops.repeat_of, points.covariance_mm2, points.quaternion) == (None,) * 9


def test_empty_cells_of_optional_columns_are_unknown():
    text = with_columns(
        "dir2,time_s,temperature_C,tau1_Nm,tau2_Nm,tau3_Nm,repeat_of", ",,,,,,", "-1,7,21,1,2,3,1"
    )

    stops = read(text).calibration.stops

    assert stops.direction.tolist() == [[0, 0, 0], [0, -1, 0]]
    assert stops.repeat_of.tolist() == [-1, 1]
    assert np.isnan([stops.time_s[0], stops.temperature_c[0], *stops.torque_n_mm[0]]).all()
    assert stops.torque_n_mm[1].tolist() == [1000.0, 2000.0, 3000.0]


def test_unknown_columns_are_reported_once_by_name():
    campaign = read(with_columns("operator,shift", "Ann,early", "Bob,late"))

    assert tuple(map(english, campaign.ignored)) == (
        "calibration.csv: column operator is not part of the format and is ignored.",
        "calibration.csv: column shift is not part of the format and is ignored.",
    )


def test_validation_readings_that_identify_as_well_are_reported():
    text = "\n".join([PLAIN, "3,6,15,25,1,111,210,310,0.03"])
    files = campaign_files(make_campaign(validation=make_points()))
    copied = {**files, "calibration.csv": PLAIN, "validation.csv": text}

    campaign = campaign_from(lambda name: copied[name].encode())

    assert tuple(map(english, campaign.ignored)) == (
        "validation.csv: 2 of 3 readings are also in calibration.csv; these readings validate nothing.",
    )


def test_another_reading_of_the_same_configuration_may_judge():
    files = campaign_files(make_campaign(validation=make_points()))
    again = {
        **files,
        "calibration.csv": PLAIN,
        "validation.csv": PLAIN.replace("100,200,300", "100.01,200,300"),
    }
    only_the_other = again["validation.csv"].replace("\n" + ROWS[1], "")

    campaign = campaign_from(lambda name: {**again, "validation.csv": only_the_other}[name].encode())

    assert campaign.ignored == ()


def test_a_revisit_of_other_joints_is_reported():
    campaign = read(with_columns("repeat_of", "", "1"))

    assert tuple(map(english, campaign.ignored)) == (
        "calibration.csv: column repeat_of: configuration 2 is not a repeat of 1, whose joints differ by 5 "
        "deg (cases in total: 1): correct the entry or leave it empty.",
    )


@pytest.mark.parametrize(("q1_deg", "repeated"), [("0.01", "1"), ("5", "77"), ("5", "-1")])
def test_a_revisit_within_the_controller_s_resolution_and_one_of_another_file_are_silent(q1_deg, repeated):
    text = f"{HEADER},repeat_of\n{ROWS[0]},\n2,{q1_deg},10,20,1,100,200,300,0.02,{repeated}"

    assert read(text).ignored == ()


def test_another_unit_beside_the_right_one_is_only_an_unknown_column():
    campaign = read(with_columns("x_m", "0.1", "0.11"))

    assert campaign.calibration.position_mm[0, 0] == 100.0
    assert "column x_m" in english(campaign.ignored[0])


def test_a_rounded_quaternion_is_brought_to_unit_length():
    campaign = read(with_columns("qw,qx,qy,qz", "0.707,0.707,0,0", "0.577,0.577,0.577,0"))

    # three decimals: 0.707 stands for 0.70711, so the length is off by 1.5e-4, and exact after normalising
    assert np.linalg.norm(campaign.calibration.quaternion, axis=1) == pytest.approx([1.0, 1.0], abs=1e-15)


def test_uncertainty_along_and_across_the_beam_becomes_a_covariance():
    text = with_columns("u_along_mm,u_across_mm", "0.01,0.03", "0.01,0.03")

    campaign = read(text, tracker_position_mm=(100.0, 200.0, 1300.0))

    # the first point lies 1000 mm straight below the tracker: along is z
    expected = np.diag([0.03**2, 0.03**2, 0.01**2])
    assert campaign.calibration.covariance_mm2[0] == pytest.approx(expected, abs=1e-18)  # rounding of 1e-3
    beam = np.array([10.0, 10.0, -990.0]) / np.sqrt(2 * 10.0**2 + 990.0**2)
    along = beam @ campaign.calibration.covariance_mm2[1] @ beam
    assert along == pytest.approx(0.01**2, rel=1e-12)


def test_a_full_covariance_supersedes_the_beam_and_says_so():
    cells = "0.01,0.03,4e-4,1e-5,0,4e-4,0,9e-4"
    text = with_columns("u_along_mm,u_across_mm,cxx,cxy,cxz,cyy,cyz,czz", cells, cells)

    campaign = read(text)

    expected = [[4e-4, 1e-5, 0.0], [1e-5, 4e-4, 0.0], [0.0, 0.0, 9e-4]]
    assert campaign.calibration.covariance_mm2[1].tolist() == expected
    assert "u_along_mm and u_across_mm are ignored" in english(campaign.ignored[0])
