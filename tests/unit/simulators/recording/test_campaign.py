from dataclasses import replace

import numpy as np
import pytest

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.rigid import register
from truepose_simulators.recording import NoStopsError, RecordingRequest, record
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ToolSetup

TILTED = load_scenario("irb120-tilted")
NOISE_FREE = replace(TILTED, noise=False)


def planted(scenario, *changes):
    return replace(scenario, effects=changes)


def test_a_campaign_has_what_was_wished_for():
    campaign = record(
        TILTED, 1, RecordingRequest(configurations=40, validation=25, revisits=5, attachments=4)
    )

    calibration, validation = campaign.calibration.stops, campaign.validation.stops
    assert (len(calibration), len(validation)) == (45, 25)
    # Four equal parts of 45 stops, the last mounting stays for the validation.
    assert np.unique(calibration.attachment, return_counts=True)[1].tolist() == [12, 11, 11, 11]
    assert set(validation.attachment) == {4.0}
    # 45 times 28 s, each within 20 %.
    assert 0.8 * 28 * 45 <= calibration.time_s[-1] <= 1.2 * 28 * 45
    assert (np.diff(np.concatenate([calibration.time_s, validation.time_s])) > 0).all()


def test_revisits_stand_at_the_same_joints_in_another_order():
    stops = record(
        TILTED, 1, RecordingRequest(configurations=40, validation=0, revisits=10)
    ).calibration.stops

    again = stops.repeat_of[40:]
    assert not stops.repeat_of[:40].any()
    assert np.array_equal(stops.joints_deg[40:], stops.joints_deg[again - 1])
    assert np.array_equal(stops.nest[40:], stops.nest[again - 1])
    assert (np.diff(again) < 0).any()
    assert len(set(again)) == 10


def test_the_same_wishes_give_the_same_campaign_and_another_seed_another_one():
    first, same, other = (record(TILTED, seed, RecordingRequest(20, 5)) for seed in (1, 1, 2))

    assert np.array_equal(first.calibration.readings.position_mm, same.calibration.readings.position_mm)
    assert np.array_equal(first.references.readings.position_mm, same.references.readings.position_mm)
    assert not np.isin(other.calibration.stops.joints_deg, first.calibration.stops.joints_deg).any()


def test_configurations_do_not_depend_on_what_is_planted():
    change = PlantedChange("joint_gain", "joint 3", 1e-3)

    clean, changed = (
        record(scenario, 1, RecordingRequest(20, 5)) for scenario in (TILTED, planted(TILTED, change))
    )

    assert np.array_equal(clean.calibration.stops.joints_deg, changed.calibration.stops.joints_deg)


def test_every_joint_comes_from_where_it_was_or_always_from_below():
    mixed = record(TILTED, 1, RecordingRequest(30, 0)).calibration.stops
    below = record(TILTED, 1, RecordingRequest(30, 0, approach="from_below")).calibration.stops

    assert np.array_equal(mixed.direction[1:], np.sign(np.diff(mixed.joints_deg, axis=0)))
    assert (below.direction == 1.0).all()


def test_without_noise_a_reading_is_the_truth_as_far_as_the_certificate_places_the_tracker():
    campaign = record(NOISE_FREE, 1, RecordingRequest(30, 0))

    off = campaign.calibration.readings.position_mm - campaign.calibration.true_mm

    # Fixed nests are certified to 0.002: at most some um of shift, and of turn over a metre.
    assert 0.0 < np.abs(off).max() < 0.015


def test_what_was_read_differs_from_the_truth_by_noise_and_scatter():
    campaign = record(TILTED, 2, RecordingRequest(400, 0))

    off = campaign.calibration.readings.position_mm - campaign.calibration.true_mm
    off -= off.mean(axis=0)  # the registration, common to all readings
    expected = np.sqrt(np.mean(campaign.calibration.readings.u_mm**2) + 0.0035**2)

    # 1,200 coordinates: 2 %, four of these; the turn of the registration (2 um per metre) vanishes beside it.
    assert off.std() == pytest.approx(expected, rel=0.08)


def test_each_stop_shows_a_nest_that_faces_the_tracker():
    campaign = record(NOISE_FREE, 3, RecordingRequest(50, 0))
    stops = campaign.calibration.stops

    rest = campaign.cell.rest(
        campaign.cell.conditions(
            np.radians(stops.joints_deg), stops.direction, stops.time_s, stops.attachment
        )
    )
    facing = np.einsum("nij,nj->ni", rest.bodies.last_frame[:, :3, :3], campaign.cell.facing[stops.nest - 1])
    towards = campaign.cell.tracker.frame[:3, 3] - campaign.calibration.true_mm
    cosine = np.sum(facing * towards, axis=1) / np.linalg.norm(towards, axis=1)
    # The tripod stands some 5 mm, the arm 1 mm off: a quarter of a degree.
    assert (cosine > np.cos(np.radians(30.25))).all()
    assert set(stops.nest) == {1, 2, 3}


def test_fixed_nests_are_read_at_every_tenth_stop():
    campaign = record(TILTED, 1, RecordingRequest(30, 20))
    times = np.concatenate([campaign.calibration.stops.time_s, campaign.validation.stops.time_s])

    assert np.unique(campaign.references.time_s).tolist() == times[::10].tolist()
    assert campaign.references.fixed_nest.tolist() == [1, 2, 3] * 5
    certified = np.array(TILTED.table.fixed_nests_mm)[campaign.references.fixed_nest - 1]
    assert np.abs(campaign.references.readings.position_mm - certified).max() < 0.08  # four deviations


def test_fixed_nests_may_be_left_alone():
    assert len(record(TILTED, 1, RecordingRequest(10, 0, reference_every=0)).references.time_s) == 0


def test_an_instrument_that_drifts_is_seen_on_fixed_nests_and_on_the_arm_alike():
    drift = PlantedChange("instrument_drift", "tracker", 0.6, details={"direction": [0.0, 0.0, 1.0]})
    campaign = record(planted(NOISE_FREE, drift), 1, RecordingRequest(100, 100))
    still = record(NOISE_FREE, 1, RecordingRequest(100, 100))

    for seen, calm, times in (
        (campaign.validation.readings, still.validation.readings, still.validation.stops.time_s),
        (campaign.references.readings, still.references.readings, still.references.time_s),
    ):
        moved = seen.position_mm - calm.position_mm
        assert moved[:, 2] == pytest.approx(-0.6 * times / 3600.0, abs=1e-9)


def test_a_base_that_drifts_is_seen_on_the_arm_alone():
    drift = PlantedChange("base_drift", "base", 0.6, details={"direction": [0.0, 0.0, 1.0]})
    campaign = record(planted(NOISE_FREE, drift), 1, RecordingRequest(50, 0))
    still = record(NOISE_FREE, 1, RecordingRequest(50, 0))

    moved = campaign.calibration.readings.position_mm - still.calibration.readings.position_mm

    assert moved[:, 2] == pytest.approx(0.6 * still.calibration.stops.time_s / 3600.0, abs=1e-9)
    assert np.array_equal(campaign.references.readings.position_mm, still.references.readings.position_mm)


def test_a_wrong_scale_stays_in_the_readings_of_a_registered_tracker():
    scale = PlantedChange("instrument_scale", "tracker", 1e-4)
    campaign = record(planted(NOISE_FREE, scale), 1, RecordingRequest(10, 0))
    still = record(NOISE_FREE, 1, RecordingRequest(10, 0))

    nests, true = (some.references.readings.position_mm[:3] for some in (campaign, still))

    # A rigid motion cannot take it away: the side of 1,000 mm is read 0.1 mm too long.
    side = np.linalg.norm(nests[1] - nests[0]) - np.linalg.norm(true[1] - true[0])
    assert side == pytest.approx(0.1, rel=1e-4)


def test_swapped_labels_are_written_down_and_the_reading_stays_where_it_was():
    swap = PlantedChange("label_swap", "nest 1, nest 2", 1.0)
    swapped, honest = (
        record(scenario, 1, RecordingRequest(40, 0)) for scenario in (planted(TILTED, swap), TILTED)
    )

    other = np.array([0, 2, 1, 3])

    assert np.array_equal(swapped.calibration.nest, other[honest.calibration.nest])
    assert np.array_equal(swapped.calibration.readings.position_mm, honest.calibration.readings.position_mm)


def test_the_sensor_shows_the_warm_up():
    growth = PlantedChange("thermal_growth", "links", 18e-6)
    warm, still = (
        record(scenario, 1, RecordingRequest(100, 0)).calibration
        for scenario in (planted(TILTED, growth), TILTED)
    )

    warming = 6.0 * (1.0 - np.exp(-still.stops.time_s / 2400.0))
    assert warm.temperature_c - still.temperature_c == pytest.approx(warming, abs=1e-9)


def test_a_tool_that_nobody_sees_is_told():
    away = ToolSetup(acceptance_deg=0.001)

    with pytest.raises(NoStopsError, match="configurations only; 50 are required"):
        record(replace(TILTED, tool=away), 1, RecordingRequest(40, 10))


@pytest.mark.parametrize(
    ("wish", "sentence"),
    [
        ({"configurations": 0}, '"configurations" must be 1 or more'),
        ({"validation": -1}, '"validation" must be 0 or more'),
        ({"attachments": 0}, '"attachments" must be 1 or more'),
        ({"reference_every": -3}, '"reference_every" must be 0 or more'),
        ({"revisits": 101}, '"revisits" must be 0 to 100, not 101'),
        ({"approach": "sideways"}, '"approach" must be mixed or from_below, not "sideways"'),
    ],
)
def test_an_impossible_wish_is_refused(wish, sentence):
    with pytest.raises(ScenarioError) as caught:
        RecordingRequest(**wish)

    assert sentence in str(caught.value)


def test_a_registration_finds_the_motion_even_where_three_points_could_be_mirrored():
    rng = np.random.default_rng(3)
    turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    points = np.array([[600.0, -500.0, 0.0], [600.0, 500.0, 0.0], [-350.0, 500.0, 0.0]])

    placed = register(points, points @ turn.T + [1.0, 2.0, 3.0])

    assert placed[:3, :3] == pytest.approx(turn, abs=1e-12)
    assert placed[:3, 3] == pytest.approx([1.0, 2.0, 3.0], abs=1e-9)
