import numpy as np
import pytest

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import EFFECTS

SUBJECTS = {
    "axis_parallelism": "joint 3",
    "backlash": "joints",
    "ballbar_zero": "ballbar",
    "base_compliance": "base",
    "base_drift": "base",
    "base_shift": "base",
    "compliance": "joint 2",
    "compliance_nonlinear": "joints",
    "fixture_shift": "placement 1",
    "instrument_drift": "tracker",
    "instrument_scale": "tracker",
    "joint_coupling": "joint 6",
    "joint_gain": "joint 3",
    "joint_harmonics": "joint 6",
    "label_swap": "nest 1, nest 2",
    "link_bending": "links",
    "link_mass": "links",
    "nest_offset": "nest 2",
    "outliers": "readings",
    "payload": "tool",
    "thermal_growth": "links",
    "tool_reseating": "tool",
}


def test_every_effect_of_the_cell_is_tried_here():
    assert sorted(EFFECTS) == sorted(SUBJECTS)


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.parametrize(
    "subject", ["", "joint 0", "joint 7", "joint 3 ", "link 9", "nest 4", "nest 2, nest 1", "arm"]
)
def test_a_subject_that_the_cell_does_not_have_is_refused(bench, name, subject):
    with pytest.raises(ScenarioError, match=rf'effect {name}: subject "{subject}" must be .*"'):
        bench.effect(name, subject, 1e-9)


@pytest.mark.parametrize("name", SUBJECTS)
def test_a_detail_that_the_effect_does_not_know_is_refused_by_name(bench, name):
    with pytest.raises(ScenarioError, match=rf'effect {name}: unknown key "colour"'):
        bench.effect(name, SUBJECTS[name], 1e-9, colour="red")


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.parametrize("amplitude", [1e9, float("inf"), float("nan")])
def test_an_amplitude_beyond_all_sense_is_refused_with_what_would_do(bench, name, amplitude):
    with pytest.raises(ScenarioError, match=rf"effect {name}: amplitude must be .* to .*, not"):
        bench.effect(name, SUBJECTS[name], amplitude)


@pytest.mark.parametrize("name", SUBJECTS)
def test_an_effect_of_no_amplitude_changes_nothing(bench, at, name):
    effect = bench.effect(name, SUBJECTS[name], 0.0, from_s=1.0)
    stops = at(np.full((4, 6), 20.0), time_s=np.full(4, 5000.0), temperature_c=np.full(4, 30.0))

    assert not bench.moved_mm(stops, effect).any()
    if hasattr(effect, "displacement_mm"):
        assert not effect.displacement_mm(stops.time_s, np.random.default_rng(1)).any()


@pytest.mark.parametrize("name", SUBJECTS)
@pytest.mark.parametrize("from_s", [1e300, float("nan")])
def test_a_time_that_never_comes_is_refused(bench, name, from_s):
    with pytest.raises(ScenarioError, match=rf"effect {name}: from_s must lie within"):
        bench.effect(name, SUBJECTS[name], 0.0, from_s=from_s)


@pytest.mark.parametrize(
    ("name", "subject", "amplitude", "details", "sentence"),
    [
        ("joint_harmonics", "joint 6", 0.03, {"order": 0.0}, 'key "order" of joint 6 must be above 0'),
        ("joint_harmonics", "joint 6", 0.03, {"order": 100.5}, "at most 100, twice the gear ratio"),
        ("joint_harmonics", "joint 6", 0.03, {"order": "two"}, 'key "order" must be a number'),
        ("joint_coupling", "joint 6", 1e-4, {"source": "joint 6"}, "must be another joint"),
        (
            "joint_coupling",
            "joint 6",
            1e-4,
            {"source": "joint 7"},
            'key "source" "joint 7" must be "joint 1"',
        ),
        ("axis_parallelism", "joint 4", 0.01, {}, "not nominally parallel"),
        (
            "base_drift",
            "base",
            0.1,
            {"direction": [0, 0, 0]},
            'key "direction" must be a vector with a direction',
        ),
        (
            "base_drift",
            "base",
            0.1,
            {"direction": [1e308] * 3},
            'key "direction" must be a vector with a direction',
        ),
        ("base_drift", "base", 0.1, {"axis": [1, 0]}, 'key "axis" must have 3 entries'),
        ("base_shift", "base", 0.1, {"rotation_rad": 3.0}, 'key "rotation_rad" must be within 0.1'),
        ("payload", "tool", -3.0, {}, "the tool weighs 2.7 kg"),
        ("payload", "tool", 1.0, {"centre_shift_mm": [0, 0, 1e9]}, 'key "centre_shift_mm" must stay within'),
        ("link_mass", "link 2", -5.0, {}, "link 2 weighs 4.2 kg"),
        ("tool_reseating", "tool", 0.1, {"rotation_rad": -1.0}, 'key "rotation_rad" must be 0 to 0.1'),
        ("thermal_growth", "links", 1e-5, {"time_constant_s": 0.0}, 'key "time_constant_s" must be 1 to'),
        ("thermal_growth", "links", 1e-5, {"warm_up_k": 1e9}, 'key "warm_up_k" must be -60 to 60'),
        ("compliance_nonlinear", "joints", 0.3, {"t0_n_mm": 0.0}, 'key "t0_n_mm" must be 1 to'),
        ("outliers", "readings", 0.3, {"size_mm": -1.0}, 'key "size_mm" must be 0 to 1000'),
        ("ballbar_zero", "ballbar", 0.01, {"course": "up"}, 'key "course" must be constant or growing'),
        ("ballbar_zero", "ballbar", 0.01, {"grown_s": 0.0}, 'key "grown_s" must be 1 to'),
        ("fixture_shift", "placement 1", 0.1, {"rotation_rad": 3.0}, 'key "rotation_rad" must be within 0.1'),
        ("fixture_shift", "placement 1", 0.1, {}, "from_s, when the fixture moves, must be"),
    ],
)
def test_details_that_make_no_sense_are_refused(bench, name, subject, amplitude, details, sentence):
    with pytest.raises(ScenarioError) as caught:
        bench.effect(name, subject, amplitude, **details)

    assert sentence in str(caught.value)
    assert name in str(caught.value)


def test_an_unknown_effect_is_refused_with_the_known_names(bench):
    with pytest.raises(
        ScenarioError, match=r'unknown effect "joint_pain"; known: axis_parallelism, backlash'
    ):
        bench.effect("joint_pain", "joint 3", 1e-3)
