"""What a night says of the causes that it planted."""

from types import SimpleNamespace

import pytest

from truepose.night.calibrated_cells import wavy_gear_case
from truepose.night.planted_causes import _checks, _PlantedCause, planted_causes
from truepose_simulators.scenarios.file import load_scenario

WAVE = _PlantedCause("joint_harmonics", "joint 4", 0.04, {"order": 3.0})


def finding(effect="joint_harmonics", subject="joint 4", amplitude=0.041, rivals=(), confidence="certain"):
    return {
        "effect": effect,
        "subject": subject,
        "amplitude": amplitude,
        "amplitude_standard_uncertainty": 0.001,
        "unit": "deg",
        "confidence": confidence,
        "confusable_with": [{"effect": one, "subject": other} for one, other in rivals],
    }


def judged(verdict, findings=(), small=()):
    document = {"verdict": verdict, "findings": list(findings), "small_findings": list(small)}
    run = SimpleNamespace(
        identification={"status": "converged"}, converged=True, diagnosis={"document": document}
    )
    return SimpleNamespace(run=run)


def checks(*findings, small=()):
    return {check.figure: check for check in _checks(judged("explained", findings, small), WAVE)}


def test_a_wave_that_is_not_found_is_missed_with_what_was_found_instead():
    status, diagnosis = wavy_gear_case(3).checks(judged("consistent"))

    assert status.passed
    assert (diagnosis.passed, diagnosis.measured, diagnosis.target) == (
        False,
        "consistent",
        "harmonic of joint 6",
    )


def test_a_cause_that_is_named_with_its_size_passes():
    found = checks(finding(), finding("backlash", "joint 2"))

    assert found["cause"].passed and found["amplitude"].passed
    assert found["amplitude"].value == pytest.approx(1.0)


def test_a_cause_that_stands_beside_another_name_passes_without_an_amplitude():
    found = checks(finding("joint_gain", "joint 4", rivals=[("joint_harmonics", "joint 4")]))

    assert found["cause"].passed
    assert "amplitude" not in found


@pytest.mark.parametrize(
    "findings", [(), (finding("backlash", "joint 4"),), (finding(subject="joint 5"),)], ids=str
)
def test_another_cause_or_none_fails(findings):
    assert not checks(*findings)["cause"].passed


def test_a_size_that_is_far_off_fails_and_its_sign_does_not_matter():
    assert not checks(finding(amplitude=0.045))["amplitude"].passed
    assert checks(finding(amplitude=-0.0405))["amplitude"].passed


def test_a_small_finding_is_a_finding():
    assert checks(small=[finding()])["cause"].passed


@pytest.mark.parametrize("seed", range(5))
def test_every_drawn_cause_is_a_scenario_of_a_sound_robot_with_one_change(seed, tmp_path):
    for case in planted_causes(seed):
        file = tmp_path / f"{case.name}.toml"
        file.write_text(case.scenario_text, encoding="utf-8")

        (planted,) = load_scenario(str(file)).effects
        assert planted.amplitude > 0.0


def test_another_night_draws_others():
    texts = {tuple(case.scenario_text for case in planted_causes(seed)) for seed in range(5)}

    assert len(texts) == 5
