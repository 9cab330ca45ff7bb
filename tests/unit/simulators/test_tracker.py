import numpy as np
import pytest

from truepose_simulators.errors import BeamBrokenError, NoTargetError
from truepose_simulators.instruments.tracker import HOME_MM, Target, Tracker, TrackerSetup

AT_2_M = np.array([1200.0, -1600.0, 0.0])
BEAM = AT_2_M / 2000.0


class Table:
    """Reflectors that the test puts where it wants."""

    def __init__(self, **positions):
        self.targets = [Target(name, np.array(place, dtype=float), True) for name, place in positions.items()]

    def __call__(self):
        return self.targets

    def hide(self):
        self.targets = [Target(target.name, target.position_mm, False) for target in self.targets]


def make_tracker(targets, *, noise=True, **setup):
    rng = np.random.default_rng(1) if noise else None
    return Tracker(TrackerSetup(**setup), lambda: np.eye(4), targets, rng, lambda _, reading_mm: reading_mm)


def locked_tracker(*, noise=True, **setup):
    tracker = make_tracker(Table(near=AT_2_M), noise=noise, **setup)
    tracker.point(AT_2_M)
    tracker.search(0.01)
    return tracker


def test_noise_grows_with_distance_as_stated_along_and_across_the_beam():
    tracker = locked_tracker(two_face_rad=0.0)

    readings = np.array([tracker.measure(1.0).position_mm for _ in range(2000)]) - AT_2_M

    along = readings @ BEAM
    across = readings - np.outer(along, BEAM)
    # 0.008 + 0.0008 * 2 and 0.010 + 0.0035 * 2 mm; 2000 draws are good to 1.6 %, across twice as many.
    assert along.std() == pytest.approx(0.0096, rel=0.064)
    assert np.sqrt((across**2).sum(axis=1).mean() / 2) == pytest.approx(0.017, rel=0.05)
    assert np.abs(readings.mean(axis=0)).max() < 4 * 0.017 / np.sqrt(2000)


def test_the_stated_covariance_is_that_of_the_readings():
    tracker = locked_tracker(two_face_rad=0.0)
    readings = np.array([tracker.measure(1.0).position_mm for _ in range(2000)])

    stated = tracker.measure(1.0).apriori_covariance_mm2

    # Elements of a covariance from 2000 draws: sd about sqrt(2 / 2000) of the variances; four of these.
    assert np.cov(readings.T) == pytest.approx(stated, abs=4 * np.sqrt(2 / 2000) * 0.017**2)


def test_without_noise_a_reading_is_the_truth_and_still_states_an_uncertainty():
    reading = locked_tracker(noise=False).measure(1.0)

    assert reading.position_mm == pytest.approx(AT_2_M, abs=0)
    assert np.trace(reading.covariance_mm2) > 0


def test_the_two_faces_differ_by_twice_the_angles_error_and_their_mean_has_none():
    quiet = {"along_mm": 0.0, "along_mm_per_m": 0.0, "across_mm": 0.0, "across_mm_per_m": 0.0}
    tracker = locked_tracker(two_face_rad=5e-6, **quiet)
    faces = {}
    for face in (1, 2):
        tracker.face = face
        faces[face] = tracker.measure(1.0).position_mm

    # Horizontal and vertical error of 5 urad at 2 m, twice each: 0.02 mm.
    difference = faces[1] - faces[2]
    assert np.linalg.norm(difference) == pytest.approx(0.02 * np.sqrt(2), abs=1e-6)
    assert difference @ BEAM == pytest.approx(0.0, abs=1e-6)
    assert (faces[1] + faces[2]) / 2 == pytest.approx(AT_2_M, abs=1e-6)


def test_a_search_locks_on_the_reflector_nearest_to_the_beam():
    tracker = make_tracker(Table(left=(2000, 30, 0), right=(2000, -10, 0)))
    tracker.point(np.array([2000.0, 0.0, 0.0]))

    assert tracker.search(0.02)
    assert tracker.target == "right"


def test_a_search_that_is_too_narrow_finds_nothing_and_locks_on_nothing():
    tracker = make_tracker(Table(left=(2000, 30, 0)))
    tracker.point(np.array([2000.0, 0.0, 0.0]))

    assert not tracker.search(0.014)
    with pytest.raises(NoTargetError):
        tracker.measure(1.0)


def test_a_reflector_that_turns_away_breaks_the_beam_and_stays_lost():
    table = Table(near=AT_2_M)
    tracker = make_tracker(table)
    tracker.point(AT_2_M)
    tracker.search(0.01)
    table.hide()

    with pytest.raises(BeamBrokenError):
        tracker.measure(1.0)
    with pytest.raises(NoTargetError):
        tracker.measure(1.0)


def test_a_reflector_that_moves_while_it_is_measured_is_smeared():
    tracker = locked_tracker(noise=False)

    reading = tracker.measure(1.0, before_mm=AT_2_M - (0.0, 0.0, 1.2))

    assert reading.position_mm == pytest.approx(AT_2_M - (0.0, 0.0, 0.6), abs=1e-12)
    # An even motion over 1.2 mm has a variance of 1.44 / 12 mm2.
    assert reading.covariance_mm2[2, 2] - reading.apriori_covariance_mm2[2, 2] == pytest.approx(
        0.12, abs=1e-6
    )


def test_a_home_reflector_that_cannot_be_seen_is_not_locked_on():
    tracker = make_tracker(Table())

    tracker.go_home()

    assert tracker.target is None


def test_initialising_ends_in_face_1_on_the_home_reflector():
    tracker = make_tracker(Table(home=HOME_MM))
    tracker.face = 2

    tracker.initialise()

    assert (tracker.initialised, tracker.face, tracker.target) == (True, 1, "home")
