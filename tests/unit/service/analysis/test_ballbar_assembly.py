"""The campaign of a ballbar session holds what counts, as it was measured, and says where it comes from."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.sessions import make_length
from tests.helpers.domain.tracker_sessions import make_setup
from truepose.analysis.campaigns.ballbar import (
    ValidCupSetup,
    ValidLength,
    ValidReadings,
    ValidSide,
    assemble_ballbar_campaign,
)
from truepose.analysis.errors import NothingMeasuredError
from truepose.domain.ballbar import ArrivalTaken
from truepose.domain.cell import Artefact, BallbarKit, SimulatedCell
from truepose.domain.robot import Nest
from truepose.exchange.campaigns.zip_file import read_campaign_zip, write_campaign_zip

ARRIVAL = ArrivalTaken((0.1, 0.2), (0.1001, 0.2001), (1, -1), 50.0)
LEGS = (
    ValidLength(1, 4, 1, (2, 3), make_length(300.25), ARRIVAL, 4),
    ValidLength(1, 4, 2, (1, 1), make_length(299.75, initialisation=2), ARRIVAL, 6),
)
COUNTING = ValidReadings(
    LEGS,
    (ValidSide(0, (1, 2), make_length(150.1)), ValidSide(1, (2, 3), make_length(300.2))),
    (ValidCupSetup(1, 2, ARRIVAL),),
    ("Skipped: placement-1/pose-5, out of range.",),
    (7,),
)


def three_nests():
    setup = make_setup()
    nests = tuple(Nest((75.0 * k, 0.0, 100.0), 0.002) for k in range(3))
    return replace(setup, cell=replace(setup.cell, nests=nests))


def assemble(setup=None, kit=None, counting=COUNTING):
    return assemble_ballbar_campaign("session 3", setup or three_nests(), kit or BallbarKit(), counting)


def test_every_leg_is_a_row_with_the_commanded_joints():
    legs = assemble().legs

    np.testing.assert_array_equal(legs.stops.joints_rad, [ARRIVAL.commanded_rad] * 2)
    np.testing.assert_array_equal(legs.stops.direction, [ARRIVAL.direction] * 2)
    assert legs.stops.config.tolist() == [4, 6]
    assert (legs.base_point.tolist(), legs.nest.tolist()) == ([2, 1], [3, 1])
    assert legs.length_mm.tolist() == [300.25, 299.75]
    assert legs.initialisation.tolist() == [1, 2]
    assert legs.standard_uncertainty_mm.tolist() == [0.0017, 0.0017]


@pytest.mark.parametrize(("second", "instrument"), [("L1", "L1"), ("L2", "")])
def test_robot_and_instrument_are_named_where_one_read_all(second, instrument):
    setup = three_nests()
    setup = replace(setup, cell=replace(setup.cell, robot_serial_number="120-500123"))
    legs = [
        replace(leg, length=replace(leg.length, instrument_serial=serial))
        for leg, serial in zip(LEGS, ("L1", second), strict=True)
    ]

    campaign = read_campaign_zip(write_campaign_zip(assemble(setup, counting=ValidReadings(tuple(legs)))))

    assert (campaign.robot_serial_number, campaign.instrument_serial_number) == ("120-500123", instrument)


def test_triangles_and_setups_tie_the_cups():
    campaign = assemble()

    assert campaign.fixture.placement.tolist() == [0, 1]
    assert campaign.fixture.length_mm.tolist() == [150.1, 300.2]
    assert campaign.setup.base_point.tolist() == [2]
    np.testing.assert_array_equal(campaign.setup.joints_rad, [ARRIVAL.commanded_rad])
    assert (campaign.ballbar_nominal_mm, campaign.ballbar_range_mm) == (300.0, 1.0)
    assert campaign.setup_uncertainty_mm == 0.01


def test_a_session_without_triangles_has_no_such_tables():
    campaign = assemble(counting=ValidReadings(LEGS))

    assert campaign.fixture is None
    assert campaign.setup is None


def test_the_notes_name_the_papers_and_what_was_left_out():
    kit = replace(BallbarKit(), calibrator=Artefact("calibrator", "C118", "certificate 5513", "2027-03-31"))

    notes = " ".join(assemble(kit=kit).notes)

    for words in ("session 3", "L20042", "C118", "certificate 5513", "2027-03-31", "poses 7", "pose-5"):
        assert words in notes
    assert "SIMULATED" not in notes


def test_simulated_readings_say_so():
    setup = three_nests()
    cell = replace(setup.cell, simulated=SimulatedCell("lrmate-tilted", 0), devices=())

    assert "SIMULATED" in " ".join(assemble(replace(setup, cell=cell)).notes)


def test_without_a_leg_there_is_no_campaign():
    with pytest.raises(NothingMeasuredError, match="session 3"):
        assemble(counting=replace(COUNTING, legs=()))


def test_its_folder_is_read_back_as_it_was_written():
    campaign = assemble()

    back = read_campaign_zip(write_campaign_zip(campaign))

    assert back.legs.length_mm.tolist() == campaign.legs.length_mm.tolist()
    assert back.legs.initialisation.tolist() == campaign.legs.initialisation.tolist()
    assert back.fixture.length_mm.tolist() == campaign.fixture.length_mm.tolist()
    assert back.setup.base_point.tolist() == campaign.setup.base_point.tolist()
    assert back.notes == campaign.notes
    assert back.ignored == ()


def test_lengths_of_a_ballbar_without_certificate_say_so_and_keep_their_larger_uncertainty():
    kit = replace(BallbarKit(), instrument=Artefact("QC20-W", "L20042", "report 7", "2027-01-31"))
    foreign = make_length(
        300.1, instrument_serial="B-9", certificate="", certificate_expires="", standard_uncertainty_mm=0.0052
    )
    legs = (*LEGS, ValidLength(1, 5, 1, (3, 1), foreign, ARRIVAL, 5))

    campaign = assemble(kit=kit, counting=ValidReadings(legs))

    assert campaign.legs.standard_uncertainty_mm.tolist() == [0.0017, 0.0017, 0.0052]
    notes = " ".join(campaign.notes)
    assert "More than one ballbar was used" in notes
    assert "Ballbar: QC20-W, serial number L20042, certificate report 7, valid until 2027-01-31." in notes
    assert "Ballbar without a certificate, serial number B-9" in notes
    assert "0.0052 mm" in notes


def test_a_ballbar_of_which_no_paper_was_ever_stated_is_named_and_no_more():
    notes = " ".join(
        assemble(counting=ValidReadings((ValidLength(1, 4, 1, (1, 1), make_length(), ARRIVAL, 4),))).notes
    )

    assert "without a certificate" not in notes
    assert "serial number L20042" in notes
