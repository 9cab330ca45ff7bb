"""Base or instrument: what fixed nests show decides, and what they contradict is not certain."""

from dataclasses import replace

import numpy as np
import pytest

from truepose.diagnosis.diagnose import diagnose
from truepose.domain.diagnosis import Confidence
from truepose.exchange.campaigns.folder import read_campaign
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario

CONTRADICTED = english(message("causes.contradicted_by_nests"))

AT_S = 1400.0
SHIFT_MM, TURN_RAD = 0.3, 1e-4
PLANTED = """extends = "irb120-tilted"
[[effect]]
name = "{}"
subject = "{}"
amplitude = {}
from_s = {}
"""
NOTHING = 'extends = "irb120-tilted"\n'
BASE_SHIFT = PLANTED.format("base_shift", "base", SHIFT_MM, AT_S)
KICK = ("unnamed", "tracker, time, jump")


def recorded(folder, seed, text=NOTHING):
    scenario = folder / "scenario.toml"
    scenario.write_text(text, encoding="utf-8")
    write_campaign(record(load_scenario(str(scenario)), seed, RecordingRequest(), None), folder)
    return read_campaign(folder)


def kicked(campaign, seed):
    """Everything that is read moves at once, fixed nests as well: somebody pushed the tripod."""
    shift, axis = np.random.default_rng(seed).standard_normal((2, 3))
    shift, turn = SHIFT_MM * shift / np.linalg.norm(shift), TURN_RAD * axis / np.linalg.norm(axis)

    def moved(position_mm, time_s):
        return position_mm + (time_s >= AT_S)[:, None] * (shift + np.cross(turn, position_mm))

    def of_points(points):
        return replace(points, position_mm=moved(points.position_mm, points.stops.time_s))

    looks = campaign.reference
    return replace(
        campaign,
        calibration=of_points(campaign.calibration),
        validation=of_points(campaign.validation),
        reference=replace(looks, position_mm=moved(looks.position_mm, looks.time_s)),
    )


def looked_twice(campaign):
    """Fixed nests read before the first and after the last reading of the calibration only."""
    looks, last_s = campaign.reference, campaign.calibration.stops.time_s.max()
    times = np.unique(looks.time_s[looks.time_s <= last_s])
    ends = np.isin(looks.time_s, times[[0, -1]])
    return replace(
        campaign,
        reference=replace(
            looks,
            time_s=looks.time_s[ends],
            fixed_nest=looks.fixed_nest[ends],
            position_mm=looks.position_mm[ends],
            standard_uncertainty_mm=looks.standard_uncertainty_mm[ends],
        ),
    )


def first_of(campaign):
    return diagnose(campaign).findings[0]


@pytest.mark.parametrize("looked", [replace, looked_twice], ids=["every tenth", "twice"])
@pytest.mark.parametrize("seed", [1, 5, 16])
def test_an_instrument_that_was_kicked_is_told_with_certainty(tmp_path, seed, looked):
    found = first_of(looked(kicked(recorded(tmp_path, seed), seed)))

    assert (found.effect, found.subject, found.confidence) == (*KICK, Confidence.CERTAIN)


@pytest.mark.parametrize("looked", [replace, looked_twice], ids=["every tenth", "twice"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_base_that_jumped_beside_nests_that_stand_still_is_told_with_certainty(tmp_path, seed, looked):
    found = first_of(looked(recorded(tmp_path, seed, BASE_SHIFT)))

    assert (found.effect, found.confidence) == ("base_shift", Confidence.CERTAIN)
    assert CONTRADICTED not in english(found.sentence)


@pytest.mark.parametrize("effect", ["base_drift", "instrument_drift"])
@pytest.mark.parametrize("looked", [replace, looked_twice], ids=["every tenth", "twice"])
def test_of_two_drifts_the_one_that_fixed_nests_show_is_told(tmp_path, effect, looked):
    subject = effect.split("_")[0].replace("instrument", "tracker")

    found = first_of(looked(recorded(tmp_path, 1, PLANTED.format(effect, subject, 0.3, 0.0))))

    assert (found.effect, found.confidence) == (effect, Confidence.CERTAIN)


@pytest.mark.parametrize("looked", [replace, looked_twice], ids=["every tenth", "twice"])
def test_what_fixed_nests_contradict_is_not_certain_and_says_so(tmp_path, looked):
    """Nothing that is left in the library kicks an instrument."""
    (found,) = diagnose(looked(kicked(recorded(tmp_path, 1), 1)), without=("unnamed",)).findings

    assert (found.effect, found.confidence) == ("base_shift", Confidence.LIKELY)
    assert english(found.sentence).endswith(CONTRADICTED)
