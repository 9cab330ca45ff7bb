"""Campaign folders on disk: the measured ones are read, and survive being written."""

import re
import time

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign, make_points
from truepose.exchange.campaigns.folder import campaign_files, read_campaign, write_campaign
from truepose.exchange.campaigns.zip_file import read_campaign_zip, write_campaign_zip
from truepose.exchange.errors import MissingFileError
from truepose.messages.catalogue import english

# Rows of calibration, validation, legs and validation_legs, as the folders' README files state them.
ROWS = {
    "campaigns/fanuc-r2000": (72, 0, 0, 0),
    "campaigns/iiwa7-0kg": (139, 59, 0, 0),
    "campaigns/iiwa7-1p25kg": (139, 59, 0, 0),
    "campaigns/iiwa7-2p5kg": (139, 59, 0, 0),
    "campaigns/irb120-drawwire": (0, 0, 834, 208),
    "campaigns/motoman-left": (146, 62, 0, 0),
    "campaigns/motoman-right": (148, 64, 0, 0),
    "synthetic-examples/ex-ballbar-none": (0, 300, 726, 0),
    "synthetic-examples/ex-joint6-gear": (100, 300, 0, 0),
    "synthetic-examples/ex-none": (100, 300, 0, 0),
    "synthetic-examples/ex-tracker-drift": (120, 300, 0, 0),
}


@pytest.mark.parametrize("folder", ROWS)
def test_a_measured_campaign_is_read_whole_and_survives_disk_and_zip(measured_data, folder, tmp_path):
    campaign = read_campaign(measured_data / folder)

    write_campaign(campaign, tmp_path / "copy")

    tables = (campaign.calibration, campaign.validation, campaign.legs, campaign.validation_legs)
    assert tuple(0 if table is None else len(table) for table in tables) == ROWS[folder]
    files = campaign_files(campaign)
    assert campaign_files(read_campaign(tmp_path / "copy")) == files
    assert campaign_files(read_campaign_zip(write_campaign_zip(campaign))) == files


@pytest.mark.parametrize(
    "folder", ["campaigns/iiwa7-0kg", "campaigns/motoman-left", "synthetic-examples/ex-none"]
)
def test_writing_loses_no_digit_of_measured_numbers(measured_data, folder, tmp_path):
    campaign = read_campaign(measured_data / folder)

    write_campaign(campaign, tmp_path)

    again = read_campaign(tmp_path)
    for role in ("calibration", "validation"):
        before, after = getattr(campaign, role), getattr(again, role)
        assert np.array_equal(before.position_mm, after.position_mm)  # files of at most five decimals
        assert np.array_equal(before.stops.joints_rad, after.stops.joints_rad)  # and nine of a degree


def test_the_draw_wires_own_columns_are_reported_once_each(measured_data):
    campaign = read_campaign(measured_data / "campaigns" / "irb120-drawwire")

    told = list(map(english, campaign.ignored))
    assert [sentence.split(": ")[0] for sentence in told] == ["legs.csv, validation_legs.csv"] * 3
    for name, sentence in zip(("ctrl_x_mm", "ctrl_y_mm", "ctrl_z_mm"), told, strict=True):
        assert name in sentence


def test_ten_thousand_rows_are_read_without_waiting(tmp_path):
    write_campaign(make_campaign(calibration=make_points(10_000)), tmp_path)

    start_s = time.process_time()
    campaign = read_campaign(tmp_path)
    elapsed_s = time.process_time() - start_s

    assert len(campaign.calibration) == 10_000
    assert elapsed_s < 1.0  # about 0.05 s on one core; cell by cell it would be seconds


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(MissingFileError, match="there is no such campaign folder"):
        read_campaign(tmp_path / "nowhere")


def test_a_folder_without_a_description_is_named(tmp_path):
    file = re.escape(str(tmp_path / "campaign.json"))

    with pytest.raises(MissingFileError, match=rf"^{file}: there is no such file\."):
        read_campaign(tmp_path)
