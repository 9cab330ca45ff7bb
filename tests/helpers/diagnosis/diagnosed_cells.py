"""Diagnoses as a cell would give them: one for each way in which they can end."""

import numpy as np

from tests.helpers.diagnosis import answers as diagnoses
from tests.helpers.domain.builders import make_model, make_parameter
from truepose.domain.diagnosis import (
    Cause,
    Confidence,
    Dependence,
    Detail,
    Gain,
    HeldOutErrors,
    NextMeasurement,
    Noise,
    Remaining,
    RuledOut,
    Verdict,
)
from truepose.domain.identification import Statistics

NOISE_MM = 0.02
NOTHING_LEFT = Remaining(False, (), "The residuals are consistent with the stated noise.")
START = ("base", "tool", "geometry", "compliance")
FOUND_RULED_OUT = (
    *(
        RuledOut("joint_harmonics", f"joint {k}", "no wave of any order stands out of the noise", 0.2 * k)
        for k in (1, 2, 3, 4, 5)
    ),
    RuledOut("joint_gain", "joint 6", "explained by the wave: 31 BIC behind it", 0.21),
    RuledOut("joint_gain", "joint 1", "nothing left that grows with the angle", 0.77),
    RuledOut("joint_coupling", "joint 6", "27 BIC behind the wave of joint 6", 0.09),
    RuledOut("payload", "tool", "torques explain nothing more", 0.55),
    RuledOut("base_drift", "base", "nothing left that follows time", 0.91),
    RuledOut("nest_offset", "nest 1", "nothing left that follows the nest", 1.0),
    RuledOut("outliers", "readings", "no reading is farther out than noise alone would put one", 0.35),
)
UNSEEN = (
    RuledOut("backlash", "", "all configurations were approached from the same side; mix them", None, False),
    RuledOut(
        "thermal_growth", "links", "the temperature changed by 0.4 K only; measure over 5 K", None, False
    ),
    RuledOut("tool_reseating", "tool", "the tool was mounted once; mount it again", None, False),
)


def make_curve(n=100, seed=1, shape=None, **changes):
    """Residuals of joint 6 over its angle: a wave of two periods per turn, or another `shape` of x."""
    generator = np.random.default_rng(seed)
    shape = shape or (lambda x: 0.029 * np.sin(np.radians(2.0 * x + 40.0)))
    x = generator.uniform(-180.0, 180.0, n)
    line_x = np.linspace(-180.0, 180.0, 200)
    values = {
        "variable": "angle of joint 6",
        "variable_unit": "deg",
        "quantity": "error of joint 6",
        "quantity_unit": "deg",
        "x": x,
        "residual": shape(x) + generator.normal(0.0, 0.012, n),
        "standard_uncertainty": np.full(n, 0.012),
        "line_x": line_x,
        "line": shape(line_x),
        "line_band": np.full(200, 0.004),
    }
    return diagnoses.make_curve(**{**values, **changes})


def make_finding(**changes):
    """A wave of two periods in joint 6, certain, with the curve that shows it."""
    values = {
        "amplitude": 0.0293,
        "amplitude_standard_uncertainty": 0.0019,
        "p_value": 3e-11,
        "details": (Detail("order", 2.0, "1", 0.0), Detail("phase", 41.2, "deg", 3.7)),
        "sentence": "Joint 6 has a periodic error of 2 periods per turn, 0.029 deg: typical of its gear.",
        "gain": Gain(0.0612, 0.0389, (0.0171, 0.0282)),
        "share": 0.71,
        "curve": make_curve(),
    }
    return diagnoses.make_wave(**{**values, **changes})


def make_gain_finding(**changes):
    """Joint 2 turns too far; likely, because a slow wave would look the same."""
    slope = make_curve(
        seed=2,
        shape=lambda x: 2.1e-4 * x,
        variable="angle of joint 2",
        quantity="error of joint 2",
    )
    return make_finding(**{
        "effect": "joint_gain",
        "subject": "joint 2",
        "amplitude": 2.07e-4,
        "unit": "1",
        "amplitude_standard_uncertainty": 1.9e-5,
        "p_value": 0.00031,
        "confidence": Confidence.LIKELY,
        "details": (),
        "sentence": "Joint 2 turns 0.021 % further than it should.",
        "confusable_with": (Cause("joint_harmonics", "joint 2"),),
        "gain": Gain(0.0389, 0.0361, (-0.0002, 0.0059)),
        "parameters": ("gain_2",),
        "share": 0.19,
        "curve": slope,
        **changes,
    })


def statistics_of(errors_mm, noise_mm=0.0319):
    norms = np.linalg.norm(errors_mm, axis=1)
    return Statistics(
        len(norms),
        float(norms.mean()),
        float(np.sqrt((norms**2).mean())),
        float(norms.std()),
        float(norms.max()),
        noise_mm,
    )


def make_errors(n=300, components=3, before_mm=0.045, after_mm=NOISE_MM):
    """Held-out errors over a work space in front of the robot; they swirl before."""
    generator = np.random.default_rng(3)
    position = generator.uniform((150.0, -450.0, 80.0), (650.0, 450.0, 700.0), (n, 3))
    after = generator.normal(0.0, after_mm, (n, components))
    swirl = np.sin(position / 130.0)[:, :components] * before_mm
    return HeldOutErrors(np.arange(1, n + 1), position, after + swirl, after)


def _found_parameter(effect, name, value, u, **changes):
    found = {"name": name, "effect": effect, "value": value, "standard_uncertainty": u, "prior_width": 1e-3}
    return make_parameter(**found, **changes)


def make_diagnosis(**changes):
    """A wave of joint 6 explains everything, judged on 300 held-out positions."""
    errors = changes.get("errors", make_errors())
    parameters = (
        *make_model().parameters,
        _found_parameter("joint_harmonics", "wave_6_2_cos", 3.8e-4, 2.3e-5),
        _found_parameter("joint_harmonics", "wave_6_2_sin", 3.4e-4, 2.2e-5),
        _found_parameter("joint_gain", "gain_2", 2.07e-4, 1.9e-5, unit="1"),
    )
    model = make_model(
        effects=(*START, "joint_harmonics", "joint_gain"),
        parameters=parameters,
        covariance=np.diag([p.standard_uncertainty**2 for p in parameters]),
    )
    values = {
        "robot": "ABB IRB 120",
        "verdict": Verdict.EXPLAINED,
        "message": "Joint 6 has a periodic error of 2 periods per turn, 0.029 deg; with it, the model "
        "explains the readings down to their noise.",
        "start_effects": START,
        "findings": (make_finding(),),
        "quantity": "position",
        "before": None if errors is None else statistics_of(errors.before_mm),
        "after": None if errors is None else statistics_of(errors.after_mm),
        "held_out": "validation",
        "remaining": NOTHING_LEFT,
        "next_measurements": (),
        "ruled_out": (*FOUND_RULED_OUT, *UNSEEN),
        "withdrawn": (),
        "noise": Noise(
            1.04, None, "The readings scatter as stated: 1.04 times the stated uncertainty is left."
        ),
        "errors": errors,
        "model": model,
    }
    return diagnoses.make_diagnosis(**{**values, **changes})


def consistent():
    errors = make_errors(before_mm=0.0)
    return make_diagnosis(
        verdict=Verdict.CONSISTENT,
        message="The present model explains the readings within their uncertainties; nothing more was found.",
        findings=(),
        errors=errors,
        model=make_model(),
        ruled_out=(RuledOut("joint_harmonics", "joint 6", "no wave of any order", 0.4), *FOUND_RULED_OUT),
    )


def two_findings():
    proposal = NextMeasurement(
        "Turn joint 2 over its whole range, with the others as given: a wave bends, a gain does not.",
        ((0.0, -90.0, 30.0, 0.0, 45.0, 0.0), (0.0, 100.0, -60.0, 10.5, -45.0, 170.0)),
        (Cause("joint_gain", "joint 2"), Cause("joint_harmonics", "joint 2")),
    )
    return make_diagnosis(
        message="Joint 6 has a periodic error of 2 periods per turn, 0.029 deg, and joint 2 probably turns "
        "0.021 % further than it should.",
        findings=(make_finding(), make_gain_finding()),
        next_measurements=(proposal,),
        withdrawn=(
            "A wave of joint 4 (3 periods per turn) made held-out errors 0.002 mm worse and was withdrawn.",
        ),
    )


def several_waves():
    """A joint off by three waves, two of them seen."""
    details = (
        *(Detail("order", 2.0, "1", 0.0), Detail("amplitude", 0.029, "deg", 0.002)),
        *(Detail("order", 1.0, "1", 0.0), Detail("amplitude", 0.004, "deg", 0.002)),
    )
    return make_diagnosis(findings=(make_finding(spectrum=diagnoses.make_spectrum(), details=details),))


def small_findings():
    """A gain of joint 2 beside the wave that hardly helps."""
    hardly = make_gain_finding(gain=Gain(0.0365, 0.0361, (-0.0002, 0.0009)))
    return make_diagnosis(findings=(make_finding(),), small=(hardly,))


def smooth_curve(variable, unit, seed):
    generator = np.random.default_rng(seed)
    x, line_x = generator.uniform(0.0, 1.4, 100), np.linspace(0.0, 1.4, 80)
    return make_curve(
        variable=variable,
        variable_unit=unit,
        quantity="shift along x",
        quantity_unit="mm",
        x=x,
        residual=0.05 * np.tanh(4.0 * (x - 0.7)) + generator.normal(0.0, 0.02, 100),
        standard_uncertainty=np.full(100, 0.02),
        line_x=line_x,
        line=0.05 * np.tanh(4.0 * (line_x - 0.7)),
        line_band=0.01 + 0.01 * np.abs(line_x - 0.7),
    )


LEFT = Remaining(
    True,
    (
        Dependence("time", 2e-6, smooth_curve("time", "h", 5)),
        Dependence("torque of joint 2", 0.004, smooth_curve("torque of joint 2", "N*m", 6)),
    ),
    "Structure is left: it depends on time and, less surely, on the torque of joint 2.",
)


def partly_explained():
    return make_diagnosis(
        verdict=Verdict.PARTLY_EXPLAINED,
        message="Joint 6 has a periodic error of 2 periods per turn, 0.029 deg; more changes with time.",
        remaining=LEFT,
        errors=make_errors(after_mm=0.04),
    )


def unexplained():
    return make_diagnosis(
        verdict=Verdict.UNEXPLAINED,
        message="The model lacks something that depends on time; no known cause explains it.",
        findings=(),
        remaining=LEFT,
        errors=make_errors(before_mm=0.0, after_mm=0.05),
        noise=Noise(
            2.6, 4.2, "2.6 times the stated noise is left, with tails heavier than a normal distribution."
        ),
        model=make_model(),
    )


def described():
    """Structure that the model describes without a name, at nine places."""
    places = (
        diagnoses.make_described(where=f"joint {k}", over=f"angle of joint {k + 1}") for k in range(1, 10)
    )
    return make_diagnosis(
        verdict=Verdict.PARTLY_EXPLAINED,
        message="The model lacks joint harmonics (joint 6). Something is left that they do not explain.",
        remaining=diagnoses.make_rest(*places),
    )


def cross_validated():
    return make_diagnosis(held_out="cross_validation", errors=make_errors(n=50))


def of_lengths():
    zeros = np.array([0.01, -0.012, 0.004, 0.013, -0.008])
    errors = make_errors(n=180, components=1, before_mm=0.02, after_mm=0.003)
    zero = make_finding(
        effect="ballbar_zero",
        subject="ballbar",
        amplitude=0.0121,
        unit="mm",
        amplitude_standard_uncertainty=0.0008,
        details=(),
        sentence="The ballbar's zero is off by 0.012 mm, anew at each initialisation.",
        parameters=(),
        curve=make_curve(
            variable="initialisation",
            variable_unit="",
            quantity="error of the length",
            quantity_unit="mm",
            x=np.repeat(np.arange(1.0, 6.0), 20),
            residual=np.repeat(zeros, 20) + np.random.default_rng(4).normal(0.0, 0.003, 100),
            standard_uncertainty=np.full(100, 0.003),
            line_x=np.arange(1.0, 6.0),
            line=zeros,
            line_band=np.full(5, 0.0015),
        ),
    )
    return make_diagnosis(
        quantity="length",
        message="The ballbar's zero is off by 0.012 mm, anew at each initialisation.",
        findings=(zero,),
        errors=errors,
        before=statistics_of(errors.before_mm, 0.0024),
        after=statistics_of(errors.after_mm, 0.0024),
    )


def nothing_fitted():
    return make_diagnosis(
        verdict=Verdict.UNEXPLAINED,
        message="Nothing can be said: 4 configurations are too few for the initial model.",
        findings=(),
        errors=None,
        remaining=Remaining(False, (), "Nothing was fitted, so nothing is left to look at."),
        ruled_out=(),
        noise=None,
        model=None,
    )


ENDINGS = {
    "explained": make_diagnosis,
    "consistent": consistent,
    "two findings": two_findings,
    "several waves": several_waves,
    "small findings": small_findings,
    "partly explained": partly_explained,
    "unexplained": unexplained,
    "described": described,
    "cross-validated": cross_validated,
    "lengths": of_lengths,
    "nothing fitted": nothing_fitted,
}
