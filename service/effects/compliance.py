"""Compliance: a linear torsion spring in every gearbox (level 3).

theta_i turns by c_i * tau_i. The torque is the measured one where the campaign has joint torques,
gravity's where masses are known, and where neither is known the deflection is written as a sum of
products `c_i * moment`, in which it is linear: only the products can be seen, never c_i itself.

Source: thesis of A. Nubiola, 2014, annex I.
"""

import numpy as np

from service.domain.arrays import FloatArray
from service.effects.names import joint_name, joint_of
from service.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term
from service.kinematics.gravity import moment_regressor

NAME = "compliance"
_LARGEST_DEFLECTION_RAD = 0.01  # belief where the maker gives no compliance: no gearbox yields more
_LARGEST_COMPLIANCE = 2e-6  # rad/(N mm): three times the softest gearbox of the thesis
_VISIBLE_RAD = 1e-5  # a joint that never deflects by this much has no spring that could be seen
_GRAVITY_M_S2 = 9.81
_FIRST_WRIST_FRAME = 3  # 0-based; beyond it links are light
_MOMENT_DEFLECTION_RAD = 5e-3


class Compliance:
    """One spring per joint that carries torque."""

    name = NAME
    needs: frozenset[Need] = frozenset({"torque"})

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the springs, or their products with the mass moments where the masses are unknown."""
        if setting.torque_source == "unknown":
            return tuple(_product_specs(setting.robot.n_joints))
        means, widths = compliance_prior(setting)
        loaded = setting.largest_torque_n_mm * widths > _VISIBLE_RAD
        return tuple(
            ParameterSpec(joint_name("c", j), "rad/(N*mm)", float(means[j]), float(widths[j]))
            for j in np.flatnonzero(loaded).tolist()
        )

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn each joint by its spring times its torque."""
        return [Term(k, *_deflection(name, rows)) for k, name in enumerate(names)]


def compliance_prior(setting: Setting) -> tuple[FloatArray, FloatArray]:
    """Mean and width of each joint's compliance [rad/(N mm)], shape (J,) each: 100 % of the typical one."""
    typical = setting.robot.typical_compliances_rad_per_n_mm
    if typical is not None:
        return np.array(typical), np.array(typical)
    torque = np.maximum(setting.largest_torque_n_mm, 1e-9)
    return np.zeros(len(torque)), np.minimum(_LARGEST_DEFLECTION_RAD / torque, _LARGEST_COMPLIANCE)


def _product_specs(n_joints: int) -> list[ParameterSpec]:
    specs = []
    for joint in range(1, n_joints):
        for frame in range(joint, n_joints):
            light = 0.1 if frame >= _FIRST_WRIST_FRAME else 1.0
            width = light * _MOMENT_DEFLECTION_RAD / _GRAVITY_M_S2
            specs += [
                ParameterSpec(_product_name(joint, axis, frame), "rad*s2/m", 0.0, width) for axis in "xy"
            ]
    return specs


def _product_name(joint: int, axis: str, frame: int) -> str:
    return f"c_{joint + 1}*m{axis}_{frame + 1}"


def _deflection(name: str, rows: Rows) -> tuple[Port, FloatArray]:
    spring, _, moment = name.partition("*")
    joint = joint_of(spring)
    port = Port(PortKind.THETA, joint)
    if not moment:
        return port, np.zeros(len(rows.stops)) if rows.torque_n_mm is None else rows.torque_n_mm[:, joint]
    component = "xy".index(moment[1])
    return port, moment_regressor(rows.chain, joint, joint_of(moment), component, rows.gravity_m_s2)
