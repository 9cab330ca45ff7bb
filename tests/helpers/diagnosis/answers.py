"""Diagnoses with dull defaults; a test names only what it is about."""

import numpy as np

from tests.helpers.domain.builders import make_model, make_parameter, make_statistics
from truepose.domain.diagnosis import (
    Cause,
    Confidence,
    Curve,
    CurvePoints,
    Dependence,
    Described,
    Detail,
    Diagnosis,
    EffectSize,
    Finding,
    Gain,
    HeldOutErrors,
    NextMeasurement,
    Noise,
    Remaining,
    RuledOut,
    Spectrum,
    Verdict,
)


def make_curve(**changes):
    """The angle of joint 3 against what is wrong with it, three readings."""
    values = {
        "variable": "angle of joint 3",
        "variable_unit": "deg",
        "quantity": "error of joint 3",
        "quantity_unit": "deg",
        "x": np.array([-30.0, 0.0, 45.0]),
        "residual": np.array([0.01, -0.012, 0.011]),
        "standard_uncertainty": np.full(3, 0.002),
        "line_x": np.array([-30.0, 45.0]),
        "line": np.array([0.011, 0.01]),
        "line_band": np.full(2, 0.003),
    }
    return Curve(**{**values, **changes})


def make_unseen_points(**changes):
    """Two validation readings of the curve of joint 3."""
    values = {
        "x": np.array([-10.0, 20.0]),
        "residual": np.array([0.013, 0.009]),
        "standard_uncertainty": np.full(2, 0.002),
    }
    return CurvePoints(**{**values, **changes})


def make_finding(**changes):
    """Backlash of joint 3, told from a wave of the same joint by nothing yet."""
    values = {
        "effect": "backlash",
        "subject": "joint 3",
        "amplitude": 0.021,
        "unit": "deg",
        "amplitude_standard_uncertainty": 0.003,
        "p_value": 1e-6,
        "confidence": Confidence.LIKELY,
        "details": (),
        "sentence": "Joint 3 stops 0.021 deg further on when it comes from below: backlash.",
        "confusable_with": (Cause("joint_harmonics", "joint 3"),),
        "gain": Gain(0.061, 0.019, (0.036, 0.047)),
        "parameters": ("backlash_3",),
        "share": 0.8,
        "curve": make_curve(),
    }
    return Finding(**{**values, **changes})


def make_spectrum(**changes):
    """Three waves of one joint, the second large, the last hidden by noise."""
    values = {
        "order": np.array([1.0, 2.0, 7.25]),
        "amplitude_deg": np.array([0.004, 0.029, 0.0]),
        "standard_uncertainty_deg": np.full(3, 0.002),
    }
    return Spectrum(**{**values, **changes})


def make_wave(order=2.0, **changes):
    """A wave of joint 6, known for certain."""
    values = {
        "effect": "joint_harmonics",
        "subject": "joint 6",
        "amplitude": 0.029,
        "amplitude_standard_uncertainty": 0.002,
        "confidence": Confidence.CERTAIN,
        "details": (Detail("order", order, "1", 0.0), Detail("phase", 12.0, "deg", 3.0)),
        "sentence": "Joint 6 has a periodic error of 2 periods per turn, amplitude 0.029 deg.",
        "confusable_with": (),
        "parameters": ("wave_6_2_cos", "wave_6_2_sin"),
        "curve": None,
    }
    return make_finding(**{**values, **changes})


def make_extended_model(**changes):
    """A model with a parameter that no identification starts from."""
    backlash = make_parameter(name="backlash_3", effect="backlash", value=3.7e-4, standard_uncertainty=5e-5)
    return make_model(
        effects=("base", "geometry", "backlash"),
        parameters=(backlash,),
        covariance=np.array([[2.5e-9]]),
        **changes,
    )


def make_diagnosis(**changes):
    """One finding, which leaves nothing but noise."""
    values = {
        "robot": "elbow",
        "verdict": Verdict.EXPLAINED,
        "message": "One cause was found: backlash of joint 3.",
        "start_effects": ("base", "tool", "geometry", "compliance"),
        "findings": (make_finding(),),
        "quantity": "position",
        "before": make_statistics(rms_mm=0.061),
        "after": make_statistics(rms_mm=0.019),
        "held_out": "cross_validation",
        "remaining": Remaining(False, (), "The residuals are consistent with the stated noise."),
        "next_measurements": (
            NextMeasurement(
                "Measure these from both sides.",
                ((0.0, 40.0, -30.0), (5.0, 45.0, -25.0)),
                (Cause("backlash", "joint 3"), Cause("joint_harmonics", "joint 3")),
            ),
        ),
        "ruled_out": (RuledOut("thermal_growth", "links", "The temperature did not change.", None, False),),
        "withdrawn": (),
        "noise": Noise(1.02, None, "The readings scatter as stated."),
        "errors": HeldOutErrors(
            np.array([1, 2]), np.array([[100.0, 0.0, 50.0]] * 2), np.full((2, 3), 0.03), np.full((2, 3), 0.01)
        ),
        "model": make_extended_model(),
    }
    return Diagnosis(**{**values, **changes})


def make_unexplained(**changes):
    """Structure that nothing explains, and what it depends on."""
    left = Remaining(
        True, (Dependence("angle of joint 4", 1e-4, make_curve()),), "Something in joint 4's angle is left."
    )
    values = {
        "verdict": Verdict.UNEXPLAINED,
        "message": "The model misses something that no known effect explains.",
        "findings": (),
        "remaining": left,
        "next_measurements": (),
        "noise": Noise(1.6, 4.5, "The readings have heavy tails."),
    }
    return make_diagnosis(**{**values, **changes})


def make_described(**changes):
    """Something at joint 2 that follows joint 1 and has no name."""
    values = {"where": "joint 2", "over": "angle of joint 1", "worth": EffectSize(0.3, 0.9, 0.12)}
    return Described(**{**values, **changes})


def make_rest(*described, gain=None):
    """Structure that is left, with what the model describes of it."""
    gain = gain or Gain(0.37, 0.34, (0.02, 0.04))
    return Remaining(True, (), "The residuals depend on the place.", described=described, described_gain=gain)
