"""A model survives its file, and a foreign file is refused in one sentence."""

import dataclasses
import json
import math
from typing import get_args

import numpy as np
import pytest

from tests.helpers.domain.builders import make_model, make_parameter, make_robot
from truepose.domain.identification import Anchor, MeasuredZone, ModelInadequacy, Unit
from truepose.domain.robot import JointRange
from truepose.exchange.errors import (
    BadValueError,
    InputFileError,
    MissingEntryError,
    NewerVersionError,
    UnreadableFileError,
    WrongUnitError,
)
from truepose.exchange.models.file import model_from_text, model_text

ZONE = MeasuredZone(
    (JointRange(-1.0, 1.0 / 3), JointRange(0.0, 0.0), JointRange(-0.2, 0.7)), tuple(np.arange(26.0))
)
RELATIVE = 1e-12  # promised; two conversions of degrees and two roundings cost 4 * 1.1e-16


def read(text):
    return model_from_text(text.encode(), "arm.json")


def unsigned(model):
    """Return the content of a model file as versions before there were digests wrote it."""
    document = json.loads(model_text(model))
    del document["digest"]
    return document


def rich_model():
    rng = np.random.default_rng(3)
    root = rng.normal(size=(4, 4))
    parameters = (
        make_parameter(value=rng.normal() * 1e-3),
        make_parameter(name="a_3", value=rng.normal(), unit="mm"),
        make_parameter(name="c_2", effect="compliance", value=3.2e-8 * math.pi, unit="rad/(N*mm)"),
        make_parameter(name="k_2", effect="joint_gain", value=1e-5 / 3, unit="1", prior_width=math.inf),
    )
    return make_model(
        robot=make_robot(
            gear_ratios=(121.0, 121.0, 101.0),
            typical_compliances_rad_per_n_mm=(2e-8, 3.2e-8, 1.3e-7),
            calibration_ranges=(JointRange(-1.0, 1.0 / 3),) * 3,
            joint_limits=(JointRange(-2.0, 2.0),) * 3,
            rated_payload_kg=3.0,
            source="a thesis",
        ),
        parameters=parameters,
        covariance=root @ root.T * 1e-9,
        instrument_mm=(2600.0, -700.0, 500.0),
        nominal_anchors=(Anchor(1, 2, (1.5, 2.0, 3.0)),),
        nominal_leg_offset_mm=-0.5,
        torques_measured=True,
        origin_s=1234.5,
        nominal_tool_rotation_rad=(0.01, 0.02, 0.03),
        shortfall=ModelInadequacy(
            functions=(
                make_parameter(name="gap_2", effect="backlash", value=rng.normal() * 1e-4, unit="rad"),
                make_parameter(name="c_3", effect="compliance", value=1e-8 / 3, unit="rad/(N*mm)"),
            ),
            covariance=root[:2] @ root[:2].T * 1e-12,
            absorbed=rng.normal(size=(4, 2)),
            rest_mm=0.01 / 3,
        ),
    )


def assert_same(left, right):
    if dataclasses.is_dataclass(left):
        for item in dataclasses.fields(left):
            assert_same(getattr(left, item.name), getattr(right, item.name))
    elif isinstance(left, np.ndarray):
        np.testing.assert_allclose(right, left, rtol=RELATIVE, atol=0.0)
    elif isinstance(left, tuple):
        assert len(left) == len(right)
        for one, other in zip(left, right, strict=True):
            assert_same(one, other)
    elif isinstance(left, float):
        assert right == pytest.approx(left, rel=RELATIVE, abs=0.0, nan_ok=True)
    else:
        assert left == right


@pytest.mark.parametrize("model", [make_model(), rich_model()], ids=["plain", "rich"])
def test_a_model_reads_back_as_it_was(model):
    assert_same(model, read(model_text(model)))


def test_unknown_numbers_are_null_in_the_file_and_unknown_again_after_it():
    covariance = np.array([[1e-8, math.nan], [math.nan, math.nan]])
    first = make_parameter()
    second = make_parameter(name="a_3", unit="mm", standard_uncertainty=math.nan, prior_width=math.inf)
    model = make_model(parameters=(first, second), covariance=covariance, discrepancy_mm=math.nan)

    text = model_text(model)

    assert "NaN" not in text
    assert "Infinity" not in text
    assert_same(model, read(text))


def test_a_person_reads_degrees_and_units():
    document = unsigned(make_model())

    angle, length = document["parameters"]
    assert (angle["unit"], length["unit"]) == ("deg", "mm")
    assert angle["value"] == pytest.approx(math.degrees(1e-3), rel=1e-15)
    assert angle["standard_uncertainty"] == pytest.approx(math.degrees(1e-4), rel=1e-15)
    assert document["covariance"][0][0] == pytest.approx(math.degrees(1e-4) ** 2, rel=1e-14)
    assert document["covariance"][0][1] == pytest.approx(math.degrees(5e-7), rel=1e-14)
    assert document["robot"]["dhm_nominal"][1]["alpha_deg"] == -90.0
    assert document["units"]["angle"] == "deg"


@pytest.mark.parametrize("unit", get_args(Unit))
def test_a_parameter_of_every_unit_reads_back_as_it_was(unit):
    rate = make_parameter(name="b", effect="base_drift", value=math.pi * 1e-5, unit=unit)
    model = make_model(parameters=(rate, make_parameter(name="a_3", unit="mm")))

    assert_same(model, read(model_text(model)))


def test_a_person_reads_a_turning_base_in_degrees_per_hour():
    rate = make_parameter(name="base_drift_rz", effect="base_drift", value=1e-3, unit="rad/h")

    (shown,) = unsigned(make_model(parameters=(rate,), covariance=np.eye(1) * 1e-8))["parameters"]

    assert (shown["unit"], shown["value"]) == ("deg/h", pytest.approx(math.degrees(1e-3), rel=1e-15))


def test_a_file_from_before_there_were_drifts_counts_time_from_zero():
    document = unsigned(make_model(origin_s=77.0))
    del document["origin_s"]

    assert read(json.dumps(document)).origin_s == 0.0


def test_every_row_of_the_covariance_takes_one_line():
    lines = model_text(make_model()).splitlines()

    start = lines.index(' "covariance": [')
    assert [line.count(",") for line in lines[start + 1 : start + 3]] == [2, 1]


def edited(**changes):
    return json.dumps({**unsigned(make_model()), **changes})


def test_a_newer_version_is_refused_before_anything_else():
    text = json.dumps({"format": "truepose-model", "version": 2, "parameters": "of another kind"})

    with pytest.raises(NewerVersionError) as refusal:
        read(text)

    assert str(refusal.value) == (
        "arm.json, line 1, key version: the model file has version 2, "
        "this program reads up to 1; update truepose."
    )


@pytest.mark.parametrize(
    "text",
    ['{"format": 1, "robot": "a campaign"}', "[]", "3", "null", '{"format": "other"}'],
)
def test_another_kind_of_document_is_refused(text):
    with pytest.raises(UnreadableFileError, match="this is not a model file"):
        read(text)


def test_the_measured_zone_comes_back_and_may_be_absent():
    model = dataclasses.replace(make_model(), zone=ZONE)
    document = unsigned(model)
    zone = read(json.dumps(document)).zone
    del document["measured_zone"]

    assert zone.extents_mm == ZONE.extents_mm
    assert zone.joint_ranges[2].upper_rad == pytest.approx(ZONE.joint_ranges[2].upper_rad, rel=1e-15)
    assert read(json.dumps(document)).zone is None


def test_a_zone_of_another_arm_is_refused():
    document = unsigned(dataclasses.replace(make_model(), zone=ZONE))
    document["measured_zone"]["joint_ranges_deg"].pop()

    with pytest.raises(InputFileError, match="2 ranges are given for the 3 joints"):
        read(json.dumps(document))


def test_every_cut_of_the_file_is_refused():
    text = model_text(make_model()).rstrip()

    for end in range(0, len(text), 37):
        with pytest.raises(UnreadableFileError):
            read(text[:end])


@pytest.mark.parametrize(
    "key",
    sorted(
        unsigned(make_model()).keys()
        - {"format", "units", "origin_s", "measured_zone", "shortfall", "targets"}
    ),
)
def test_a_missing_key_is_named(key):
    document = unsigned(make_model())
    del document[key]

    with pytest.raises((MissingEntryError, WrongUnitError), match=f"key {key} is missing"):
        read(json.dumps(document))


@pytest.mark.parametrize(
    ("changes", "key", "sentence"),
    [
        ({"covariance": [[1.0]]}, "covariance", "1 entries found where 2"),
        ({"covariance": [[1.0, 0.5], [0.4, 1.0]]}, "covariance", "must be symmetric"),
        ({"covariance": [[1.0, 2.0], [2.0, 1.0]]}, "covariance", "correlations beyond 1"),
        ({"covariance": [[-1.0, 0.0], [0.0, 1.0]]}, "covariance", "negative variances"),
        ({"repeatability_mm": 1e200}, "repeatability_mm", "not a plausible length"),
        ({"torques_measured": 1}, "torques_measured", "must be true or false"),
        ({"identified_from": {"rows": [1]}}, "identified_from.rows", "text or a number"),
        (
            {"targets": [{"target": 1, "kind": "banana"}]},
            "targets[0].kind",
            "'banana' must be one of sphere, wire",
        ),
        (
            {"measured_zone": {"joint_ranges_deg": [[9, -5]] * 3, "flange_extents_mm": [0] * 26}},
            "measured_zone.joint_ranges_deg[0]",
            "the lower end 9 is above the upper end -5",
        ),
        ({"tool_nests": [{"nest": 0, "centre_mm": [0, 0, 0]}]}, "tool_nests[0].nest", "must lie between 1"),
    ],
)
def test_a_value_that_cannot_be_meant_is_named(changes, key, sentence):
    with pytest.raises(BadValueError, match=sentence) as refusal:
        read(edited(**changes))

    assert refusal.value.key == key


def test_a_covariance_whose_sums_vary_less_than_nothing_is_refused():
    three = tuple(make_parameter(name=f"a_{k}", unit="mm") for k in (1, 2, 3))
    text = model_text(make_model(parameters=three, covariance=np.where(np.eye(3) > 0.0, 1.0, -0.9)))

    with pytest.raises(BadValueError, match="nor may any combination of its parameters"):
        read(text)


def test_a_unit_of_another_program_is_refused():
    document = unsigned(make_model())
    document["parameters"][0]["unit"] = "arcmin"

    with pytest.raises(BadValueError, match="'arcmin' is not a unit of this file") as refusal:
        read(json.dumps(document))

    assert refusal.value.key == "parameters[0].unit"


def test_a_beta_of_the_table_comes_back_and_is_written_only_where_there_is_one():
    joints = list(make_robot().joints)
    joints[2] = dataclasses.replace(joints[2], beta_rad=1e-3)
    text = model_text(make_model(robot=make_robot(joints=tuple(joints))))

    assert text.count("beta_deg") == 1
    assert read(text).robot.joints[2].beta_rad == pytest.approx(1e-3, rel=RELATIVE)
