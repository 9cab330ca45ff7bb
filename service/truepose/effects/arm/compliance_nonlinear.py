"""Nonlinear compliance: a gear that is softer while it carries little, until all its teeth bear.

    theta_i moves by  soft_i t0 tanh(tau_i / t0)        slope soft_i / cosh^2(tau_i / t0)

On top of c tau: near zero torque the gear is softer by `soft`, far beyond t0 it has its own stiffness again.
A negative `soft` is a gear that is stiffer near zero. Strain-wave gears behave so (T. D. Tuttle, W. P.
Seering, IEEE Trans. Robotics and Automation 12(3), 1996, 368-374); the shape is our own, the simplest one
with these two slopes that is linear in its parameter.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Detail
from truepose.domain.singular_covariance import solve_singular
from truepose.effects.arm.compliance import VISIBLE_RAD, compliance_prior, known_torque
from truepose.effects.causes import (
    FEWEST_TOGETHER,
    OF_SUBJECT,
    Candidate,
    Description,
    FittedCause,
    Limits,
    Scene,
    Signature,
)
from truepose.effects.names import joint_name, joint_subject
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term
from truepose.messages.message import Text, message

NAME = "compliance_nonlinear"
_T0_N_MM = (500.0, 1000.0, 2000.0, 4000.0, 8000.0)  # where softness may end, for arms of 3 to 20 kg
_USUAL_T0_N_MM = 2000.0
_STIFF = 20.0  # times t0, where all teeth bear: the slope is 1e-17 of what it is at zero
_SHARE_WIDTH = 2.0  # belief: four times the softness, relative to the spring's own, that is often met
_LIMITS = Limits(-1.0, np.inf, message("limits.stiff"))
_BENT = 0.5  # of t0: a joint whose torque stays below has no bend in its characteristic that could be seen


class ComplianceNonlinear:
    """Additional compliance near zero torque of every gearbox that carries torque."""

    name = NAME
    needs: frozenset[Need] = frozenset({"torque"})
    signature = Signature(
        OF_SUBJECT,
        "torque of {subject}",
        "curve",
        "relative additional compliance near zero torque",
        plural="joints",
        drawn="joint",
    )

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the softness of every loaded joint below 2 N m."""
        return _specs(setting, _USUAL_T0_N_MM)

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn each joint by what its teeth give before they bear: weight t0 tanh(tau / t0) [N mm]."""
        return [Term(k, *_give(name, rows)) for k, name in enumerate(names)]

    def softness(
        self, names: tuple[str, ...], values: FloatArray, joint: int, load_n_mm: FloatArray | None
    ) -> FloatArray | float:
        """Return what teeth that do not bear yet add to the spring: soft / cosh^2(load / t0).

        Parameters as of `Compliant.softness`; 0 where the load is not known.
        """
        if load_n_mm is None:
            return 0.0
        added = np.zeros(len(load_n_mm))
        for name, value in zip(names, values.tolist(), strict=True):
            if name.startswith(f"soft_{joint + 1}_"):
                # Clipped where the slope is nothing any more: cosh itself would overflow at some hundred
                # times t0.
                added += value / np.cosh(np.clip(load_n_mm / _t0_of(name), -_STIFF, _STIFF)) ** 2
        return added

    def unseen(self, scene: Scene) -> Text | None:
        """Need known torques of more than one size."""
        if scene.torque_n_mm is None:
            return message("unseen.torques_unknown")
        if not any(_bent_specs(scene, t0) for t0 in _T0_N_MM):
            return message("unseen.little_torque")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose each sprung joint, and all of them together, for every torque where softness may end.

        How a spring bends is a question only once there is a spring.
        """
        found = []
        # The law is not linear in t0, and parameters must be: each t0 is a variant of its own, chosen by how
        # well it fits.
        for t0 in _T0_N_MM if scene.torque_n_mm is not None else ():
            bent = [spec for spec in _bent_specs(scene, t0) if _is_open(spec, scene)]
            found += [Candidate(NAME, joint_subject(_joint_of(spec.name)), (spec,), t0) for spec in bent]
            specs = tuple(spec for spec in _specs(scene.setting, t0) if _is_open(spec, scene))
            if bent and len(specs) >= FEWEST_TOGETHER:
                found.append(Candidate(NAME, "joints", specs, t0))
        return tuple(found)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how much softer, relative to the spring of the model, the gears are near zero torque."""
        names, shares, covariance = _shares(fitted, scene)
        share, spread = _common(shares, covariance)
        # Joints may have been found with different t0: one number says about where softness ends.
        t0 = float(np.median([_t0_of(name) for name in fitted.names]))
        one = "causes.compliance_nonlinear.one"
        sentence = message(
            "causes.compliance_nonlinear.softer" if share >= 0.0 else "causes.compliance_nonlinear.stiffer",
            who=message("causes.compliance_nonlinear.several")
            if len(names) > 1
            else message(one, joint=names[0]),
            percent=100.0 * abs(share),
            torque_n_m=t0 / 1000.0,
        )
        details = [Detail("torque where it ends", t0 / 1000.0, "N*m", 0.0)]
        if len(names) > 1:
            spreads = np.sqrt(np.diag(covariance))
            details += [
                Detail(f"share of {name}", float(value), "1", float(deviation))
                for name, value, deviation in zip(names, shares, spreads, strict=True)
            ]
        return Description(subject, share, "1", spread, sentence, tuple(details), _LIMITS)


def _specs(setting: Setting, t0_n_mm: float) -> tuple[ParameterSpec, ...]:
    """Return the softness of every joint that torques wind up visibly; it ends at t0 [N mm]."""
    if setting.torque_source == "unknown":
        return ()
    _, widths = compliance_prior(setting)
    loaded = np.flatnonzero(setting.largest_torque_n_mm * widths > VISIBLE_RAD).tolist()
    return tuple(
        ParameterSpec(_name(joint, t0_n_mm), "rad/(N*mm)", 0.0, _SHARE_WIDTH * float(widths[joint]))
        for joint in loaded
    )


def _bent_specs(scene: Scene, t0_n_mm: float) -> tuple[ParameterSpec, ...]:
    """Return those of joints whose largest torque reaches at least half of where softness ends."""
    largest = scene.setting.largest_torque_n_mm
    return tuple(
        spec for spec in _specs(scene.setting, t0_n_mm) if largest[_joint_of(spec.name)] >= _BENT * t0_n_mm
    )


def _name(joint: int, t0_n_mm: float) -> str:
    return f"soft_{joint + 1}_{t0_n_mm:g}"


def _joint_of(name: str) -> int:
    return int(name.split("_")[1]) - 1


def _t0_of(name: str) -> float:
    return float(name.split("_")[2])


def _give(name: str, rows: Rows) -> tuple[Port, FloatArray]:
    """Return the port and weight (n,) of one parameter."""
    joint, t0 = _joint_of(name), _t0_of(name)
    return Port(PortKind.THETA, joint), t0 * np.tanh(known_torque(rows, joint) / t0)


def _shares(fitted: FittedCause, scene: Scene) -> tuple[list[str], FloatArray, FloatArray]:
    """Softness of each joint over its spring, with covariance; several t0 of one joint add up at zero.

    Returns
    -------
    names : list of str
        Of the j joints.
    shares : ndarray, shape (j,)
        [1]
    covariance : ndarray, shape (j, j)
    """
    typical, widths = compliance_prior(scene.setting)
    # Relative to the fitted spring; where the model has none, to what is believed of it: a share needs a
    # whole.
    springs = np.where(scene.softness_rad_per_n_mm > 0.0, scene.softness_rad_per_n_mm, typical)
    springs = np.where(springs > 0.0, springs, widths)
    joints = sorted({_joint_of(name) for name in fitted.names})
    gather = np.array([
        [(_joint_of(name) == joint) / springs[joint] for name in fitted.names] for joint in joints
    ])
    shares = gather @ fitted.values
    return [joint_subject(joint) for joint in joints], shares, gather @ fitted.covariance @ gather.T


def _common(shares: FloatArray, covariance: FloatArray) -> tuple[float, float]:
    """Mean share, each joint weighted by how well these data know it (generalised least squares).

    With C the covariance: s = 1^T C^-1 shares / (1^T C^-1 1), variance 1 / (1^T C^-1 1).
    """
    weights = solve_singular(covariance, np.ones(len(shares)))
    information = float(weights.sum())
    return float(weights @ shares) / information, float(1.0 / np.sqrt(information))


def _is_open(spec: ParameterSpec, scene: Scene) -> bool:
    """Say whether the model has the joint's spring and not yet its softness."""
    # Without c in the model the softness near zero would take the part of the whole spring.
    return spec.name not in scene.present and joint_name("c", _joint_of(spec.name)) in scene.present
