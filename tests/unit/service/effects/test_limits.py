"""Physical limits of amplitudes: what lies beyond them by more than it is uncertain is impossible."""

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_scene
from truepose.effects.arm.loads import stated_mass
from truepose.effects.causes import SPRING, Description, FittedCause
from truepose.effects.registry import CAUSES


def described(cause, subject, values, relative=1e-3):
    spread = relative * np.abs(list(values.values()))
    fitted = FittedCause(tuple(values), np.array(list(values.values())), np.diag(spread**2))
    return CAUSES[cause].describe(subject, fitted, telling_scene())


@pytest.mark.parametrize(
    ("cause", "subject", "possible", "impossible"),
    [
        ("compliance", "joint 3", {"c_3": 1e-7}, {"c_3": -1e-7}),
        ("compliance_nonlinear", "joint 3", {"soft_3_2000": -1e-8}, {"soft_3_2000": -1e-5}),
        ("link_bending", "link 2", {"sag_2": 1e-11}, {"sag_2": -1e-11}),
        ("base_compliance", "base", {"base_c": 1e-8}, {"base_c": -1e-8}),
        ("thermal_growth", "links", {"growth": 23e-6}, {"growth": 100e-6}),
        ("thermal_growth", "links", {"growth": -1e-6}, {"growth": -20e-6}),
        ("unnamed", "link 4, load, line", {"cell_tilt_4_line_tilt": 1e-8}, {"cell_tilt_4_line_tilt": -1e-8}),
        (
            "unnamed",
            "flange, load, line",
            {"cell_mount_0_x_tilt": 1e-6, "cell_mount_0_x_shift": -1e-4},
            {"cell_mount_0_x_tilt": -1e-6, "cell_mount_0_x_shift": 1e-4},
        ),
        (
            "unnamed",
            "joint 3, torque of joint 3, sign",
            {"cell_rub_3_line_turn": 1e-8},
            {"cell_rub_3_line_turn": -1e-8},
        ),
        (
            "unnamed",
            "link 2, temperature, line",
            {"cell_stretch_2_line_growth": 2e-5},
            {"cell_stretch_2_line_growth": 2e-4},
        ),
    ],
)
def test_each_cause_knows_what_nature_allows(cause, subject, possible, impossible):
    assert not described(cause, subject, possible).impossible
    assert described(cause, subject, impossible).impossible


@pytest.mark.parametrize("cause", ["payload", "link_mass"])
def test_a_mass_is_not_misstated_by_more_than_its_half(cause):
    scene = telling_scene()
    candidate = CAUSES[cause].candidates(scene)[0]

    def with_share(share):
        """The centre of gravity stays where it is stated."""
        frame = 6 if cause == "payload" else int(candidate.subject.split()[1])
        stated = stated_mass(scene.setting.robot, frame - 1)
        extra = share * stated.mass_kg * np.array([1.0, *stated.centre_of_gravity_mm])
        fitted = FittedCause(candidate.names, extra, np.diag([1e-8, 1e-4, 1e-4, 1e-4]))
        return CAUSES[cause].describe(candidate.subject, fitted, scene)

    assert not with_share(0.3).impossible
    assert with_share(-0.8).impossible


def test_what_reaches_beyond_a_limit_within_its_uncertainty_is_possible():
    found = Description("base", -1.0, "mm", 0.6, "It gives.", limits=SPRING)

    assert not found.impossible
    assert Description("base", -1.0, "mm", 0.4, "It gives.", limits=SPRING).impossible
