"""A base fixture that somebody bumps while the ballbar measures from it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.campaigns import LENGTH_U_MM, ballbar_campaign, places
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.diagnosis import Verdict

BUMP_MM = np.array([1.1, -0.7, 0.5])
STOPS = 68  # of each placement: more gaps than are tried, every second one
CADENCE_S = 10.0


def bumped(after, seed=4):
    """136 poses over two placements, the fixture of the second bumped after some of its stops."""
    campaign, true = ballbar_campaign(stops=STOPS, placements=2, seed=seed)
    legs = campaign.legs
    stop = np.unique(legs.stops.config, return_inverse=True)[1]
    late = (legs.placement == 2) & (stop >= STOPS + after)
    cups = np.array([
        true.cups_mm[placement][point - 1]
        for placement, point in zip(legs.placement, legs.base_point, strict=True)
    ])
    nests = places(legs.stops.joints_rad, true.nests_mm)[np.arange(len(legs)), legs.nest - 1]
    noise = LENGTH_U_MM * np.random.default_rng(seed).standard_normal(len(legs))
    length = np.linalg.norm(nests - cups - late[:, None] * BUMP_MM, axis=1) + noise
    told = replace(legs, length_mm=length, stops=replace(legs.stops, time_s=CADENCE_S * stop))
    return replace(campaign, legs=told, cups=None, validation=None)


@pytest.mark.parametrize(
    "after", [30, 31]
)  # the 31st gap is not tried: a jump is chosen on either side of it
def test_a_bumped_fixture_is_named_whether_or_not_its_moment_was_tried(after):
    diagnosis = diagnose(bumped(after))

    (shift,) = [finding for finding in diagnosis.findings if finding.effect == "fixture_shift"]
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert shift.subject == "placement 2"
    assert shift.amplitude == pytest.approx(np.linalg.norm(BUMP_MM), abs=0.02)
    assert len(shift.parameters) == 6
