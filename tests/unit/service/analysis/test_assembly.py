"""A campaign is assembled from sessions without inventing or losing anything."""

import dataclasses

import numpy as np
import pytest

from tests.helpers.domain.tracker_sessions import make_fixed_nest, make_point, make_setup
from truepose.analysis.campaigns.tracker import (
    MeasuredSession,
    assemble_campaign,
    point_readings,
    with_validation_points,
)
from truepose.analysis.errors import NothingMeasuredError, SessionsDifferError
from truepose.domain.campaign import Campaign
from truepose.domain.cell import Camera, Conditions, DeviceEntry, SimulatedCell
from truepose.domain.robot import FramePlacement
from truepose.domain.session import Registration
from truepose.storage.records import SessionSetup


def measured(number=1, points=None, **changes):
    points = (make_point(1), make_point(2)) if points is None else points
    return dataclasses.replace(MeasuredSession(number, make_setup(), points), **changes)


def changed_cell(**changes):
    return SessionSetup(dataclasses.replace(make_setup().cell, **changes))


def test_rows_are_the_points_in_the_order_they_were_taken():
    points = (make_point(7), dataclasses.replace(make_point(3), repeat_of=7, direction=(-1, 1)))

    rows = assemble_campaign(measured(points=points)).calibration

    assert rows.stops.config.tolist() == [7, 3]
    assert rows.stops.repeat_of.tolist() == [-1, 7]
    assert rows.stops.direction.tolist() == [[1, 1], [-1, 1]]
    np.testing.assert_array_equal(rows.position_mm, [p.position_world_mm for p in points])
    np.testing.assert_array_equal(rows.standard_uncertainty_mm, [0.015, 0.015])


def test_the_joints_are_the_commanded_ones():
    point = dataclasses.replace(make_point(), commanded_rad=(0.1, 0.2), reported_rad=(0.1001, 0.2001))

    rows = assemble_campaign(measured(points=(point,))).calibration

    assert rows.stops.joints_rad.tolist() == [[0.1, 0.2]]


def test_validation_readings_come_from_the_other_session_only():
    campaign = assemble_campaign(measured(1), measured(2, points=(make_point(9),)))

    assert campaign.calibration.stops.config.tolist() == [1, 2]
    assert campaign.validation.stops.config.tolist() == [9]


def test_without_a_validation_session_there_are_no_validation_readings():
    assert assemble_campaign(measured()).validation is None


def test_looks_at_fixed_nests_are_in_order_of_time_and_those_of_the_registration_left_out():
    looks = (make_fixed_nest(9.0), make_fixed_nest(1.0, "registration"), make_fixed_nest(5.0))

    reference = assemble_campaign(measured(fixed_nests=looks)).reference

    assert reference.time_s.tolist() == [5.0, 9.0]


def test_the_tracker_stands_where_its_registration_says_and_its_covariance_is_carried():
    registration = Registration(np.eye(3), np.array([2600.0, -700.0, 500.0]), np.eye(6) * 4e-6, 0.01, 0.002)

    campaign = assemble_campaign(measured(registration=registration))

    assert campaign.tracker_position_mm == (2600.0, -700.0, 500.0)
    np.testing.assert_array_equal(campaign.registration.covariance, np.eye(6) * 4e-6)


def test_a_simulated_session_says_so_in_the_notes_with_its_conditions():
    setup = changed_cell(simulated=SimulatedCell("irb120-tilted", 1), conditions=Conditions(load="2.7 kg"))

    campaign = assemble_campaign(measured(setup=setup))
    notes = campaign.notes

    assert campaign.simulated
    assert assemble_campaign(measured()).simulated is False
    assert any("SIMULATED" in note for note in notes)
    assert "Load: 2.7 kg" in notes


def test_a_session_without_readings_is_named():
    with pytest.raises(NothingMeasuredError, match="Session 4 has no reading"):
        assemble_campaign(measured(4, points=()))


def test_sessions_of_different_set_ups_are_not_joined():
    moved = changed_cell(base_nominal=FramePlacement(x_mm=10.0))

    with pytest.raises(SessionsDifferError, match="Sessions 1 and 2 differ in: base placement"):
        assemble_campaign(measured(1), measured(2, setup=moved))


def test_points_of_a_tracker_session_judge_a_campaign_of_legs_and_identify_nothing():
    calibration, tracker = measured(3, points=()), measured(5, fixed_nests=(make_fixed_nest(),))
    legs = Campaign(make_setup().cell.robot, FramePlacement(), make_setup().cell.nests, notes=("legs",))

    campaign = with_validation_points(legs, calibration, tracker)

    assert campaign.calibration is None
    assert len(campaign.validation) == 2
    assert campaign.notes == ("legs", "Validation readings from session 5.")


def test_legs_that_a_tracker_judges_are_of_no_one_instrument():
    cell = make_setup().cell
    legs = Campaign(cell.robot, FramePlacement(), cell.nests, instrument_serial_number="L1")
    tracker = measured(5, points=of_tracker("392123", 1, 2))

    assert with_validation_points(legs, measured(3, points=()), tracker).instrument_serial_number == ""


def test_a_tracker_session_of_another_robot_judges_nothing():
    other = measured(5, setup=changed_cell(robot=dataclasses.replace(make_setup().cell.robot, name="other")))
    legs = Campaign(make_setup().cell.robot, FramePlacement(), make_setup().cell.nests)

    with pytest.raises(SessionsDifferError, match="robot"):
        with_validation_points(legs, measured(3, points=()), other)


def of_tracker(serial, *configs):
    return tuple(dataclasses.replace(make_point(config), instrument_serial=serial) for config in configs)


def with_tracker(serial, certificate):
    entry = DeviceEntry("tracker", "leica_emscon", {}, serial, certificate)
    return changed_cell(devices=(entry,))


def test_a_certificate_is_stated_of_the_tracker_whose_number_it_names():
    own = measured(setup=with_tracker("390003", "KZ-4711"), points=of_tracker("390003", 1))
    other = measured(setup=with_tracker("390003", "KZ-4711"), points=of_tracker("777777", 1))

    assert "Tracker: serial number 390003, certificate KZ-4711." in assemble_campaign(own).notes
    assert "Tracker: serial number 777777, certificate not stated." in assemble_campaign(other).notes


def test_readings_of_two_trackers_are_told_apart_with_what_that_means():
    points = of_tracker("390003", 1, 2) + of_tracker("777777", 3)

    notes = assemble_campaign(measured(setup=with_tracker("390003", "KZ-4711"), points=points)).notes

    assert any("registered to the world frame separately" in note for note in notes)
    assert "Tracker: serial number 390003, certificate KZ-4711. Readings: 2." in notes
    assert "Tracker: serial number 777777, certificate not stated. Readings: 1." in notes


def test_a_campaign_is_simulated_where_any_of_its_sessions_is():
    simulated = changed_cell(simulated=SimulatedCell("irb120-tilted", 1))

    campaign = assemble_campaign(measured(1), measured(2, setup=simulated))

    assert campaign.simulated
    assert any(note.startswith("SIMULATED:") for note in campaign.notes)


def test_groups_reach_the_table_where_every_reading_is_in_one():
    grouped = [dataclasses.replace(make_point(config), group=1 + config // 3) for config in range(1, 5)]

    assert point_readings(grouped).stops.group.tolist() == [1, 1, 2, 2]
    assert point_readings([*grouped, make_point(5)]).stops.group is None
    assert point_readings([make_point()]).stops.group is None


CAMERA = Camera((2200.0, 0.0, 900.0), (0.0, 0.0, 0.0), 1, 0.03, 5e-4, 4e-4)
TURN = (0.5, 0.5, 0.5, 0.5)


def seen(config, **changes):
    changes = {"quaternion": TURN, "rotation_uncertainty_rad": 5e-4} | changes
    return dataclasses.replace(make_point(config), **changes)


def test_poses_keep_their_orientations_and_how_well_the_artefact_is_known():
    session = measured(setup=changed_cell(camera=CAMERA), points=(seen(1), seen(2)))

    campaign = assemble_campaign(session)

    assert campaign.calibration.quaternion.tolist() == [list(TURN)] * 2
    assert campaign.calibration.rotation_uncertainty_rad.tolist() == [5e-4] * 2
    assert campaign.tool_rotation_uncertainty_rad == 4e-4
    assert any("is the camera frame, placed at the camera pose" in note for note in campaign.notes)


def test_orientations_that_only_some_readings_have_are_no_column():
    campaign = assemble_campaign(measured(points=(seen(1), make_point(2))))

    assert campaign.calibration.quaternion is None
    assert campaign.tool_rotation_uncertainty_rad is None


def test_readings_of_camera_and_tracker_are_no_campaign():
    with pytest.raises(SessionsDifferError, match="camera"):
        assemble_campaign(measured(1, setup=changed_cell(camera=CAMERA)), measured(2))
