"""The documents that scripts rely on: names, units, and no NaN."""

import json
import math

import pytest

from tests.helpers.domain.builders import make_identification, make_pair
from truepose.domain.identification import NotIdentifiable, Outlier, PureError
from truepose.domain.validation import DistanceErrors, Histogram, SignedErrors, Validation
from truepose.exchange.results.identification import identification_document
from truepose.exchange.results.validation import validation_document

STATISTICS = {"n", "mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm"}


def test_an_identification_has_the_promised_keys():
    document = identification_document(make_identification(), "ABB IRB 120")

    promised = {
        "robot", "status", "message", "effects", "counts", "parameters", "not_identifiable", "outliers",
        "statistics", "chi2_per_dof", "quantity",
    }  # fmt: skip
    assert promised <= document.keys()
    assert (document["robot"], document["status"]) == ("ABB IRB 120", "converged")
    assert document["counts"] == {"configurations": 3, "observations": 9, "parameters": 2, "outliers": 0}
    assert document["statistics"]["calibration"]["nominal"].keys() == STATISTICS


def test_angles_are_in_degrees():
    angle, length = identification_document(make_identification(), "x")["parameters"]

    assert (angle["name"], angle["effect"], angle["unit"]) == ("alpha_2", "geometry", "deg")
    assert angle["value"] == pytest.approx(math.degrees(1e-3), rel=1e-15)
    assert angle["standard_uncertainty"] == pytest.approx(math.degrees(1e-4), rel=1e-15)
    assert (length["value"], length["unit"]) == (0.2, "mm")


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ((), {"cross_validation"}),
        (("validation", "calibration_without_outliers"), {"validation", "calibration_without_outliers"}),
    ],
    ids=["no validation", "validation"],
)
def test_cross_validation_stands_where_there_is_no_validation(given, named):
    identification = make_identification(**dict.fromkeys(given, make_pair()))

    blocks = identification_document(identification, "x")["statistics"]

    assert blocks.keys() == {"calibration"} | named


@pytest.mark.parametrize(
    ("validation", "named"), [(None, "cross_validation_relative"), (make_pair(), "validation_relative")]
)
def test_relative_errors_are_named_for_the_readings_that_they_are_of(validation, named):
    identification = make_identification(validation=validation, relative=make_pair())

    blocks = identification_document(identification, "x")["statistics"]

    assert {name for name in blocks if name.endswith("_relative")} == {named}


def test_findings_are_carried_over():
    identification = make_identification(
        not_identifiable=(NotIdentifiable(("theta_6", "nest_1_x"), "seen only together"),),
        outliers=(Outlier(row=4, config=12, nest=1, residual_mm=3.5, reason="3.5 mm off"),),
        pure_error=PureError(5, 15, 0.01, 1.2, 0.3),
    )

    document = identification_document(identification, "x")

    assert document["not_identifiable"] == [
        {"parameters": ["theta_6", "nest_1_x"], "reason": "seen only together"}
    ]
    assert document["outliers"] == [
        {"config": 12, "reason": "3.5 mm off", "nest": 1, "row": 4, "residual_mm": 3.5}
    ]
    assert document["pure_error"]["repeatability_mm"] == 0.01


def test_what_is_not_a_number_is_null():
    identification = make_identification(
        chi2_per_dof=math.nan, calibration=make_pair(sd_mm=math.nan, max_mm=math.inf)
    )

    document = identification_document(identification, "x")

    assert document["chi2_per_dof"] is None
    assert document["statistics"]["calibration"]["identified"]["sd_mm"] is None
    json.dumps(document, allow_nan=False)  # raises for any NaN left


def test_a_validation_has_the_promised_keys():
    signed = SignedErrors(0.004, 0.6, Histogram(0.5, -2, (1, 4, 5)))
    errors = DistanceErrors(signed, signed)
    document = validation_document(
        Validation("position", make_pair(), make_pair(), 0.5, True, distance_errors=errors)
    )

    assert document.keys() == {
        "outcome",
        "quantity",
        "position",
        "relative",
        "orientation",
        "distance",
        "distance_errors",
        "places",
        "limit_mm",
        "decision",
        "pass",
        "uncertainty",
    }
    assert document["pass"] is True
    assert document["places"] is None
    assert document["distance"]["identified"].keys() == STATISTICS
    assert document["distance_errors"]["nominal"] == {
        "mean_mm": 0.004,
        "positive_share": 0.6,
        "histogram": {"width_mm": 0.5, "from_mm": -1.0, "counts": [1, 4, 5]},
    }


def test_legs_have_no_distances():
    document = validation_document(Validation("length", make_pair(), None, None, False))

    assert (document["quantity"], document["distance"], document["distance_errors"]) == ("length", None, None)
