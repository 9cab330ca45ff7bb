"""A campaign that was written reads back equal."""

import dataclasses
import math
from datetime import date

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.helpers.domain.builders import (
    make_ballbar_campaign,
    make_campaign,
    make_points,
    make_robot,
    make_stops,
)
from truepose.domain.robot import FixedNest, FramePlacement, Nest, WorldRegistration
from truepose.exchange.campaigns.folder import campaign_files, campaign_from

# Half of the last digit that is written, in the domain's units, plus the rounding of degrees to radians.
HALF_DIGIT = {
    "joints_rad": math.radians(0.5e-9) * 1.001,
    "torque_n_mm": 0.5e-3 * 1.001,
    "time_s": 0.5e-4 * 1.001,
    "temperature_c": 0.5e-4 * 1.001,
    "quaternion": 1e-15,
    "rotation_uncertainty_rad": 1e-8,  # eight digits of at most 1 rad
    "standard_uncertainty_mm": 1e-8,  # eight digits of at most 1 mm
    "covariance_mm2": 1e-16,  # seventeen digits of at most 1 mm2
}
HALF_OF_A_LENGTH = 0.5e-5 * 1.001


def written_and_read(campaign):
    files = campaign_files(campaign)
    return campaign_from(lambda name: files[name].encode())


def assert_equal(left, right, name=""):
    if dataclasses.is_dataclass(left):
        for item in dataclasses.fields(left):
            assert_equal(getattr(left, item.name), getattr(right, item.name), item.name)
    elif isinstance(left, np.ndarray):
        tolerance = 0 if left.dtype.kind == "i" else HALF_DIGIT.get(name, HALF_OF_A_LENGTH)
        np.testing.assert_allclose(right, left, rtol=1e-15, atol=tolerance, equal_nan=True)
    elif isinstance(left, tuple):
        assert len(left) == len(right)
        for one, other in zip(left, right, strict=True):
            assert_equal(one, other, name)
    elif isinstance(left, float):
        assert right == pytest.approx(left, rel=1e-14), name  # degrees there and back
    else:
        assert left == right, name


N = 4
angles = st.floats(-7.0, 7.0)
lengths = st.floats(-5000.0, 5000.0)
uncertainties = st.floats(1e-4, 1.0)
known_or_not = st.one_of(st.just(math.nan), st.floats(-1000.0, 1000.0))


def column(values):
    return arrays(float, N, elements=values)


def whole(least, greatest):
    return arrays(np.int64, N, elements=st.integers(least, greatest))


stops = st.builds(
    make_stops,
    n=st.just(N),
    config=arrays(np.int64, N, elements=st.integers(0, 2**40), unique=True),
    joints_rad=arrays(float, (N, 3), elements=angles),
    direction=st.none() | arrays(np.int64, (N, 3), elements=st.integers(-1, 1)),
    time_s=st.none() | column(known_or_not),
    temperature_c=st.none() | column(known_or_not),
    attachment=st.none() | whole(-3, 9),
    torque_n_mm=st.none() | arrays(float, (N, 3), elements=known_or_not),
    group=st.none() | whole(0, 9),
    repeat_of=st.none() | whole(-1, 9),
)


def unit(quaternion):
    return quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)


def definite(root):
    return root @ root.swapaxes(1, 2) + 1e-6 * np.eye(3)


points = st.builds(
    make_points,
    n=st.just(N),
    stops=stops,
    nest=whole(1, 2),
    position_mm=arrays(float, (N, 3), elements=lengths),
    standard_uncertainty_mm=column(uncertainties),
    covariance_mm2=st.none() | arrays(float, (N, 3, 3), elements=st.floats(-0.5, 0.5)).map(definite),
    quaternion=st.none() | arrays(float, (N, 4), elements=st.floats(0.1, 1.0)).map(unit),
    rotation_uncertainty_rad=st.none() | column(st.one_of(st.just(math.nan), uncertainties)),
)
nests = st.tuples(
    st.just(Nest(None)),
    st.builds(
        Nest,
        st.tuples(lengths, lengths, lengths),
        st.none() | uncertainties,
        st.none() | st.just((0.6, 0.0, 0.8)),
    ),
)
placements = st.none() | st.builds(FramePlacement, lengths, lengths, lengths, angles, angles, angles)


@settings(max_examples=50)
@given(points, nests, placements, st.booleans())
def test_a_tracker_campaign_reads_back_equal_twice(calibration, tool_nests, base, repeatability_included):
    campaign = make_campaign(
        calibration=calibration,
        nests=tool_nests,
        base_nominal=base,
        repeatability_in_uncertainty=repeatability_included,
        tracker_position_mm=(2600.0, -700.5, 1 / 3),
        tool_rotation_uncertainty_rad=4.2e-4,
    )

    again = written_and_read(campaign)

    # Revisits drawn at random seldom have the joints of what they repeat, which reading says.
    assert_equal(campaign, dataclasses.replace(again, ignored=()))
    assert campaign_files(written_and_read(again)) == campaign_files(again)


def test_a_ballbar_campaign_reads_back_equal():
    campaign = make_ballbar_campaign(notes=("the cup of B2 was replaced", "größer"))

    again = written_and_read(campaign)

    assert_equal(campaign, again)


def test_everything_else_of_the_description_reads_back_equal():
    root = np.random.default_rng(5).normal(size=(6, 6)) * 0.01
    campaign = make_campaign(
        robot=make_robot(
            gear_ratios=(121.0, 101.0, 50.0), typical_compliances_rad_per_n_mm=(2e-8, 1.3e-7, 6.05e-7)
        ),
        fixed_nests=(FixedNest((600.0, -500.0, 0.0), 0.002), FixedNest((600.0, 500.0, 0.1), 0.003)),
        registration=WorldRegistration(root @ root.T),
        gravity_m_s2=(0.1, 0.0, -9.80),
        nests=(Nest((0.0, 0.0, 1.0), 0.002), Nest((0.0, 1.0, 1.0), 0.004)),
    )

    again = written_and_read(campaign)

    assert_equal(campaign, again)
    assert np.array_equal(campaign.registration.covariance, again.registration.covariance)


def test_unknown_values_become_empty_cells_and_not_nan():
    stops = make_stops(time_s=np.array([1.0, math.nan, 3.0]))

    text = campaign_files(make_campaign(calibration=make_points(stops=stops)))["calibration.csv"]

    assert "nan" not in text.lower()


@pytest.mark.parametrize("simulated", [True, False, None])
def test_what_was_measured_by_what_and_on_which_day_travels_with_a_campaign(simulated):
    who = {"robot_serial_number": "A-7", "instrument_serial_number": "T-9"}
    campaign = make_campaign(simulated=simulated, measured_on=date(2025, 11, 3), **who)

    read = written_and_read(campaign)

    assert (read.simulated, read.measured_on, read.ignored) == (simulated, date(2025, 11, 3), ())
    assert (read.robot_serial_number, read.instrument_serial_number) == ("A-7", "T-9")


@pytest.mark.parametrize(
    ("note", "simulated"),
    [("SIMULATED: no robot took part.", True), ("SIMULATED load of 3 kg", None), ("simulated", None)],
)
def test_an_archive_of_an_earlier_version_says_by_its_note_that_it_is_simulated(note, simulated):
    assert written_and_read(make_campaign(notes=(note,))).simulated is simulated
