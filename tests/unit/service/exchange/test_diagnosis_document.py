"""A diagnosis is printed with every promised key, in finite numbers."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.answers import (
    make_curve,
    make_described,
    make_diagnosis,
    make_finding,
    make_rest,
    make_spectrum,
    make_unexplained,
    make_unseen_points,
    make_wave,
)
from truepose.domain.diagnosis import EffectSize, Gain, RuledOut, Scatter
from truepose.exchange.results.diagnosis import diagnosis_document
from truepose.storage.documents import from_document, to_document

WAVY = make_diagnosis(
    findings=(make_wave(spectrum=make_spectrum(), curve=make_curve(unseen=make_unseen_points())),)
)


def printed(diagnosis):
    """The document as another program reads it: strict JSON."""
    return json.loads(json.dumps(diagnosis_document(diagnosis), allow_nan=False))


def test_a_finding_is_printed_as_promised():
    document = printed(make_diagnosis(findings=(make_wave(),)))

    (finding,) = document["findings"]
    assert document["robot"] == "elbow"
    assert document["verdict"] == "explained"
    assert finding.items() >= {
        ("effect", "joint_harmonics"),
        ("subject", "joint 6"),
        ("confidence", "certain"),
        ("amplitude", 0.029),
        ("unit", "deg"),
        ("amplitude_standard_uncertainty", 0.002),
    }
    assert finding["details"][0] == {"name": "order", "value": 2, "unit": "1", "standard_uncertainty": 0}
    assert finding["gain"] == {
        "rms_before_mm": 0.061,
        "rms_after_mm": 0.019,
        "interval_95_mm": [0.036, 0.047],
    }
    assert set(document["before"]) == {"n", "mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm"}
    assert document["remaining"] == {
        "structure": False,
        "depends_on": [],
        "sentence": "The residuals are consistent with the stated noise.",
        "described": [],
        "described_gain": None,
    }
    assert document["held_out"] == "cross_validation"


def test_what_cannot_be_told_apart_and_what_would_tell_it_stand_side_by_side():
    document = printed(make_diagnosis())

    rival = {"effect": "joint_harmonics", "subject": "joint 3"}
    assert document["findings"][0]["confusable_with"] == [rival]
    assert rival in document["next_measurements"][0]["separates"]
    assert document["next_measurements"][0]["configurations_deg"][1] == [5.0, 45.0, -25.0]


def test_what_is_left_says_what_it_depends_on_with_its_curve():
    document = printed(make_unexplained())

    (left,) = document["remaining"]["depends_on"]
    assert (document["verdict"], document["findings"]) == ("unexplained", [])
    assert (left["variable"], left["p_value"]) == ("angle of joint 4", 1e-4)
    assert left["curve"]["line_band"] == [0.003, 0.003]
    assert document["noise"]["tail_degrees_of_freedom"] == 4.5
    assert document["noise"]["scatter"] is None


def test_noise_that_depends_on_something_says_on_what_and_how_large_it_is_at_both_ends():
    scatter = Scatter("angle", "joint 5", -40.0, 0.02, 90.0, 0.07, 1e-6)
    noise = replace(make_diagnosis().noise, scatter=scatter)

    found = printed(make_diagnosis(noise=noise))["noise"]["scatter"]

    assert (found["variable"], found["subject"], found["unit"]) == ("angle", "joint 5", "deg")
    assert (found["at_low"], found["low_mm"], found["at_high"], found["high_mm"]) == (-40.0, 0.02, 90.0, 0.07)


def test_where_nothing_could_be_fitted_the_blocks_are_null():
    document = printed(make_unexplained(before=None, after=None, noise=None, errors=None, model=None))

    assert (document["before"], document["after"], document["noise"]) == (None, None, None)


def test_no_number_is_anything_but_finite():
    unknown = make_finding(
        amplitude=math.nan,
        gain=Gain(math.nan, 0.02, (-math.inf, math.inf)),
        curve=make_curve(residual=np.array([math.nan, 0.0, math.inf])),
    )

    (finding,) = printed(make_diagnosis(findings=(unknown,)))["findings"]

    assert finding["amplitude"] is None
    assert finding["gain"]["interval_95_mm"] == [None, None]
    assert finding["curve"]["residual"] == [None, 0.0, None]


@pytest.mark.parametrize(
    "diagnosis",
    [make_diagnosis(), make_unexplained(), make_unexplained(remaining=make_rest(make_described())), WAVY],
    ids=["explained", "not", "described", "waves"],
)
def test_a_stored_diagnosis_prints_the_same_document(diagnosis):
    kept = json.loads(json.dumps(to_document(replace(diagnosis, model=None)), allow_nan=False))

    again = from_document(type(diagnosis), kept)

    assert diagnosis_document(again) == diagnosis_document(diagnosis)
    np.testing.assert_array_equal(again.errors.before_mm, diagnosis.errors.before_mm)


def test_a_finding_says_its_place_its_variable_its_shape_and_its_worth():
    placed = make_wave(
        where="joint 6", over="angle of joint 6", shape="wave", worth=EffectSize(0.04, math.nan)
    )

    (finding,) = printed(make_diagnosis(findings=(placed,)))["findings"]

    assert (finding["where"], finding["over"], finding["shape"]) == ("joint 6", "angle of joint 6", "wave")
    assert finding["worth"] == {"mean_mm": 0.04, "max_mm": None, "own_mm": None}


def test_what_is_described_without_a_name_is_printed_with_what_it_gains():
    rest = make_rest(make_described(), make_described(over="constant"))

    left = printed(make_unexplained(remaining=rest))["remaining"]

    assert left["described"][0] == {
        "where": "joint 2",
        "over": "angle of joint 1",
        "worth": {"mean_mm": 0.3, "max_mm": 0.9, "own_mm": 0.12},
    }
    assert len(left["described"]) == 2
    assert left["described_gain"]["rms_after_mm"] == 0.34


@pytest.mark.parametrize(
    ("today", "since"),
    [
        (make_rest(make_described()), {"described": (), "described_gain": None}),
        (replace(make_diagnosis(), model=None), {"small": ()}),
        (make_wave(), {"where": "", "over": "", "shape": None, "worth": None, "spectrum": None}),
    ],
    ids=["what is left", "a diagnosis", "a finding"],
)
def test_what_an_earlier_version_stored_is_read_without_what_came_since(today, since):
    stored = to_document(today)
    for name in since:
        del stored[name]

    read = from_document(type(today), stored)

    assert {name: getattr(read, name) for name in since} == since


def test_waves_of_several_orders_are_printed_by_their_order():
    several = make_wave(spectrum=make_spectrum())

    first, second = printed(make_diagnosis(findings=(several, make_wave())))["findings"]

    assert first["spectrum"]["order"] == [1.0, 2.0, 7.25]
    assert set(first["spectrum"]) == {"order", "amplitude_deg", "standard_uncertainty_deg"}
    assert second["spectrum"] is None


def test_a_curve_has_the_readings_that_were_never_fitted_where_there_are_some():
    curves = make_curve(unseen=make_unseen_points()), make_curve()

    document = printed(make_diagnosis(findings=[make_finding(curve=curve) for curve in curves]))

    with_unseen, without = (finding["curve"]["unseen"] for finding in document["findings"])
    assert with_unseen == {
        "x": [-10.0, 20.0],
        "residual": [0.013, 0.009],
        "standard_uncertainty": [0.002, 0.002],
    }
    assert without is None


def test_small_findings_have_the_document_of_findings_and_a_list_of_their_own():
    document = printed(make_diagnosis(findings=(make_finding(),), small=(make_wave(),)))

    assert [one["effect"] for one in document["findings"]] == ["backlash"]
    assert [one["effect"] for one in document["small_findings"]] == ["joint_harmonics"]
    assert set(document["small_findings"][0]) == set(document["findings"][0])


def test_what_was_ruled_out_says_how_large_it_could_still_be():
    limited = RuledOut("backlash", "joint 2", "nothing", 0.4, upper_limit_mm=0.018)

    entries = printed(make_diagnosis(ruled_out=(limited, replace(limited, upper_limit_mm=None))))["ruled_out"]

    assert [entry["upper_limit_mm"] for entry in entries] == [0.018, None]
