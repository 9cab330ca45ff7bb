"""Campaigns in which nothing is hidden: the present model is enough, and that is said."""

import pytest

from tests.studies.diagnosis_report.trials import Trial


@pytest.mark.parametrize(("readings", "seed"), [(50, 61), (100, 61), (100, 62), (200, 61)])
@pytest.mark.parametrize("heavy_tails", [False, True], ids=["normal noise", "heavy tails"])
def test_a_robot_without_further_effects_is_consistent(readings, heavy_tails, seed, diagnosed):
    diagnosis, _ = diagnosed(Trial("nothing", (), readings, seed, heavy_tails=heavy_tails))

    assert diagnosis.verdict == "consistent", diagnosis.message
    assert diagnosis.findings == ()
    assert not diagnosis.remaining.structure
    assert diagnosis.after == diagnosis.before


def test_heavy_tails_are_called_noise(diagnosed):
    diagnosis, _ = diagnosed(Trial("nothing", (), 200, 61, heavy_tails=True))

    assert diagnosis.noise.tail_degrees_of_freedom is not None
    assert diagnosis.findings == ()


def test_another_robot_is_consistent_too(diagnosed):
    diagnosis, _ = diagnosed(Trial("nothing", (), 100, 61, scenario="lrmate-tilted"))

    assert diagnosis.verdict == "consistent", diagnosis.message


def test_an_everyday_robot_predicts_better_with_what_was_found(diagnosed):
    everyday = Trial("everyday", (), 100, 61, scenario="irb120-everyday", over_time=False)

    diagnosis, _ = diagnosed(everyday)

    assert diagnosis.findings
    # The mean of many robots shall reach 0.52; one of them may lie a little above.
    assert diagnosis.after.mean_mm < 0.60 * diagnosis.before.mean_mm
