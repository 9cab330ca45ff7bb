"""What is planned for: cells as described, robots as measured."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import IRB_120, domain_cell
from tests.helpers.identification.synthetic import leg_campaign, measured, nominal_campaign
from truepose.domain.cell import DeviceEntry, SimulatedCell
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Nest
from truepose.exchange.cells.file import cell_given
from truepose.exchange.robots.named import list_robots
from truepose.identification import identify
from truepose.planning.prediction.errors import NONE
from truepose.planning.prediction.robots_and_cells import TYPICAL, of_campaign, of_cell
from truepose.planning.prediction.tracker import promised_session

TRACKER_MM = (2600.0, -700.0, 500.0)


def test_a_cell_without_real_devices_is_taken_to_be_what_its_parameters_say():
    cell = domain_cell(IRB_120, tracker_position_mm=TRACKER_MM)
    real = replace(cell, devices=(DeviceEntry("tracker", "emscon", {}),))

    assert of_cell(cell).knowns.discrepancy == NONE
    assert of_cell(real).knowns.discrepancy == TYPICAL
    simulated = replace(real, simulated=SimulatedCell("irb120-tilted", 0))  # as a service has it
    assert of_cell(simulated).knowns.discrepancy == NONE


@pytest.mark.parametrize("robot", list_robots())
def test_every_robot_of_the_catalogue_can_be_planned_for_by_its_name(robot):
    subject = of_cell(cell_given(robot))

    plan = promised_session(subject.space, 20, knowns=subject.knowns, n_candidates=1500)

    assert len(plan.joints_rad) == 20
    assert plan.promised.n == 20
    assert np.all(np.abs(plan.joints_rad) <= np.pi)


def test_a_robot_of_which_nobody_says_how_far_it_turns_is_refused_in_one_sentence():
    cell = domain_cell(IRB_120, tracker_position_mm=TRACKER_MM)
    robot = replace(cell.robot, calibration_ranges=None, joint_limits=None)

    with pytest.raises(ConfigurationError, match=r"Joint limits are missing .* Enter `calibration_deg`"):
        of_cell(replace(cell, robot=robot))


def test_sizes_that_are_given_count():
    subject = of_cell(domain_cell(IRB_120, tracker_position_mm=TRACKER_MM)).reading(0.07).lacking(0.2)

    assert subject.knowns.accuracy.along_mm == subject.knowns.accuracy.across_mm == 0.07
    assert subject.knowns.discrepancy.per_axis_mm == 0.2


def test_a_campaign_is_gone_on_with_from_what_was_measured():
    campaign, _ = measured(nominal_campaign(40))

    subject = of_campaign(campaign, identify(campaign).model)
    plan = promised_session(
        subject.space, 5, knowns=subject.knowns, measured=subject.measured, n_candidates=300
    )

    assert subject.measured.configurations == plan.measured == 40
    assert len(plan.joints_rad) == 5
    assert subject.knowns.discrepancy.known_to == pytest.approx(0.13, abs=0.01)  # of 40 - 31 / 3
    lowest = campaign.calibration.position_mm[:, 2].min()
    assert subject.space.table_z_mm < lowest


def test_unknown_nests_stay_unknown_and_are_where_they_were_found():
    known, _ = measured(nominal_campaign(80))
    unknown = tuple(Nest(None) for _ in known.nests)

    campaign = replace(known, nests=unknown)
    subject = of_campaign(campaign, identify(campaign).model)

    found = np.array([nest.centre_mm for nest in subject.space.nests])
    true = np.array([nest.centre_mm for nest in known.nests])
    assert np.abs(found - true).max() < 1.0
    assert all(nest.centre_mm is None for nest in subject.knowns.nests)


def test_a_base_that_nobody_knew_is_where_it_was_found():
    known, _ = measured(nominal_campaign(60))
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    elsewhere = known.calibration.position_mm @ turn.T + (3000.0, -1000.0, 400.0)
    readings = replace(known.calibration, position_mm=elsewhere)
    campaign = replace(known, calibration=readings, base_nominal=None, tracker_position_mm=None)

    subject = of_campaign(campaign, identify(campaign).model)
    plan = promised_session(
        subject.space, 5, knowns=subject.knowns, measured=subject.measured, n_candidates=300
    )

    base = subject.space.base
    assert (base.x_mm, base.y_mm, base.z_mm) == pytest.approx((3000.0, -1000.0, 400.0), abs=3.0)
    assert base.rz_rad == pytest.approx(np.pi / 2.0, abs=0.01)
    assert len(plan.joints_rad) == 5
    assert not subject.knowns.base_known


def test_a_campaign_of_lengths_cannot_be_gone_on_with():
    model = identify(measured(nominal_campaign(40))[0]).model

    with pytest.raises(ConfigurationError, match="ballbar"):
        of_campaign(leg_campaign(12), model)
