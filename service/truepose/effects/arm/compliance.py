"""Compliance: a linear torsion spring in every gearbox (level 3).

    theta_i moves by  c_i tau_i                                   torques known
                      sum over frames f >= i of (c_i m_kf) z_i . (e_kf x g)      masses unknown, k = x, y

The torque is the measured one where the campaign has joint torques, gravity's where masses are known, and
where neither is known the deflection is written as a sum of products `c_i * moment`, in which it is linear:
only the products can be seen, never c_i itself. Torques are those of the deflected arm, where the thesis
takes the undeflected one (docs/decisions/0003).

Source: thesis of A. Nubiola, 2014, annex I. Products: M. Gautier, W. Khalil, IEEE Trans. Robotics and
Automation 6(3), 1990, 368-373.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.domain.identification import NotIdentifiable
from truepose.effects.causes import (
    OF_SUBJECT,
    SPRING,
    Candidate,
    Description,
    FittedCause,
    Scene,
    Signature,
    norm_with_uncertainty,
)
from truepose.effects.names import joint_name, joint_of, joint_subject
from truepose.effects.ports import Need, ParameterSpec, Port, PortKind, Rows, Setting, Term, Trait
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import rotation_x, rotation_y
from truepose.kinematics.gravity import moment_regressor
from truepose.messages.message import Text, message

NAME = "compliance"
_LARGEST_DEFLECTION_RAD = 0.01  # belief where the maker gives no compliance: no gearbox yields more
_LARGEST_COMPLIANCE = 2e-6  # rad/(N mm): three times the softest gearbox of the thesis
VISIBLE_RAD = 1e-5  # a joint that never deflects by this much has no spring that could be seen
_GRAVITY_M_S2 = 9.81
_UPRIGHT = float(np.sin(np.deg2rad(2.0)))  # no floor or ceiling on which an arm is levelled leans as much
_FIRST_WRIST_FRAME = 3  # 0-based; beyond it links are light
_MOMENT_DEFLECTION_RAD = 5e-3
_ONLY_PRODUCTS = message("open.only_products")


class Compliance:
    """One torsional compliance per joint that carries torque."""

    name = NAME
    needs: frozenset[Need] = frozenset({"torque"})
    traits = frozenset({Trait.SPRINGS})
    signature = Signature(
        OF_SUBJECT,
        "torque of {subject}",
        "line",
        "joint rotation per unit torque about its axis",
        drawn="joint",
    )

    def automatic(self, setting: Setting) -> bool:
        """Where masses or torques are known."""
        return setting.torque_source != "unknown"

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the springs, or their products with the mass moments where the masses are unknown."""
        if setting.torque_source == "unknown":
            return tuple(_product_specs(setting))
        means, widths = compliance_prior(setting)
        # What the spring could do at most and not the torque itself: stiff gears of heavy arms count like
        # soft ones.
        loaded = setting.largest_torque_n_mm * widths > VISIBLE_RAD
        return tuple(
            ParameterSpec(joint_name("c", j), "rad/(N*mm)", float(means[j]), float(widths[j]))
            for j in np.flatnonzero(loaded).tolist()
        )

    def left_open(self, names: tuple[str, ...], setting: Setting) -> list[NotIdentifiable]:
        """Return the springs that carry nothing; all where only their products with moments are seen.

        Parameters as of `LeavesOpen.left_open`.
        """
        if setting.torque_source == "unknown":
            return [
                NotIdentifiable(tuple(joint_name("c", j) for j in _loaded_joints(setting)), _ONLY_PRODUCTS)
            ]
        joints = range(setting.robot.n_joints)
        _, widths = compliance_prior(setting)
        largest_rad = setting.largest_torque_n_mm * widths
        # A joint whose spring is no parameter is not said to be stiff: how far it would turn at most is told
        # with it.
        idle = (joint for joint in joints if joint_name("c", joint) not in names)
        return [_idle_spring(joint, float(largest_rad[joint]), setting) for joint in idle]

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Turn each joint by its spring times its torque: weight tau [N mm], of products [N mm/(kg mm)]."""
        return [Term(k, *_deflection(name, rows)) for k, name in enumerate(names)]

    def softness(
        self, names: tuple[str, ...], values: FloatArray, joint: int, load_n_mm: FloatArray | None
    ) -> FloatArray | float:
        """Return the joint's spring, the same at any load; 0 where it has none.

        Parameters as of `Compliant.softness`.
        """
        name = joint_name("c", joint)
        return float(values[names.index(name)]) if name in names else 0.0

    def unmodelled(self, setting: Setting, stops: Stops) -> bool:
        """Where masses tell the load at any target too."""
        return setting.torque_source == "masses"

    def unseen(self, scene: Scene) -> Text | None:
        """Need joints that carry torque."""
        if not self.specs(scene.setting):
            return message("unseen.no_torque")
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose the spring of each loaded joint; as products, those of the heavy links alone, and all."""
        by_joint: dict[int, list[ParameterSpec]] = {}
        for spec in self.specs(scene.setting):
            if spec.name not in scene.present:
                by_joint.setdefault(_sprung_joint(spec.name), []).append(spec)
        found = []
        for joint, specs in by_joint.items():
            heavy = [spec for spec in specs if _is_heavy(spec.name)]
            if 0 < len(heavy) < len(specs):
                # The two or four products of the heavy links may be worth their number where all are not.
                found.append(Candidate(NAME, joint_subject(joint), tuple(heavy), float(len(heavy))))
            found.append(Candidate(NAME, joint_subject(joint), tuple(specs)))
        return tuple(found)

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Say how soft the gearbox is; of products, by how much it winds up (standard deviation)."""
        if "*" in fitted.names[0]:
            return _shown_products(subject, fitted, scene)
        spring, spread = float(fitted.values[0]), float(np.sqrt(fitted.covariance[0, 0]))
        joint = joint_of(fitted.names[0])
        largest = 0.0 if scene.torque_n_mm is None else float(np.nanmax(np.abs(scene.torque_n_mm[:, joint])))
        most_deg = float(np.rad2deg(abs(spring) * largest))
        sentence = message("causes.compliance", joint=subject, spring=spring, most_deg=most_deg)
        # A spring that turns against its load is not even kept as likely: under more load than was measured a
        # model with it errs by more than one without.
        return Description(
            subject, spring, "rad/(N*mm)", spread, sentence, limits=SPRING._replace(withdrawn=True)
        )


def compliance_prior(setting: Setting) -> tuple[FloatArray, FloatArray]:
    """Mean and width of each joint's compliance: 100 % of the typical one where the maker gives it.

    Else mean 0 and the width at which the largest torque turns the joint by 0.01 rad, 2e-6 rad/(N mm) at
    most.

    Parameters
    ----------
    setting : Setting

    Returns
    -------
    mean, width : ndarray, shape (J,)
        [rad/(N mm)]
    """
    typical = setting.robot.typical_compliances_rad_per_n_mm
    if typical is not None:
        return np.array(typical), np.array(typical)
    # An upright axis carries nothing; the upper bound of the width then decides, and no division by zero.
    torque = np.maximum(setting.largest_torque_n_mm, 1e-9)
    return np.zeros(len(torque)), np.minimum(_LARGEST_DEFLECTION_RAD / torque, _LARGEST_COMPLIANCE)


def _loaded_joints(setting: Setting) -> range:
    """Return the 0-based joints about which gravity has a moment somewhere: all but an upright first one."""
    return range(1 if _is_upright(setting) else 0, setting.robot.n_joints)


def _is_upright(setting: Setting) -> bool:
    """Say whether axis 1, which alone never moves, is along gravity."""
    row, gravity = setting.robot.joints[0], np.array(setting.gravity_m_s2)
    axis_1 = (rotation_x(row.alpha_rad) @ rotation_y(row.beta_rad))[:, 2]
    return bool(np.linalg.norm(np.cross(axis_1, gravity)) <= _UPRIGHT * np.linalg.norm(gravity))


def _product_specs(setting: Setting) -> list[ParameterSpec]:
    """Propose the products of each joint that gravity may load with the moments of all frames it carries.

    Widths: a deflection of 5 mrad under gravity, a tenth of that for the light frames of the wrist.
    """
    specs = []
    for joint in _loaded_joints(setting):
        for frame in range(joint, setting.robot.n_joints):
            # Widths hold what few readings do not see, and the moments of the wrist's light links are small.
            light = 0.1 if frame >= _FIRST_WRIST_FRAME else 1.0
            width = light * _MOMENT_DEFLECTION_RAD / _GRAVITY_M_S2
            specs += [
                ParameterSpec(_product_name(joint, axis, frame), "rad*s2/m", 0.0, width) for axis in "xy"
            ]
    return specs


def _product_name(joint: int, axis: str, frame: int) -> str:
    return f"c_{joint + 1}*m{axis}_{frame + 1}"


def _sprung_joint(name: str) -> int:
    return joint_of(name.partition("*")[0])


def _is_heavy(name: str) -> bool:
    _, product, moment = name.partition("*")
    return not product or joint_of(moment) < _FIRST_WRIST_FRAME


def _shown_products(subject: str, fitted: FittedCause, scene: Scene) -> Description:
    """Describe products by the standard deviation of the deflection that they make over the readings [deg].

    Deflections are M p, of centred columns M = QR: their mean square is |R p|^2 / n, and R C R^T / n is the
    covariance of that vector.
    """
    gravity = np.array(scene.gravity_m_s2)
    columns = [_regressor(name, scene.chain, gravity) for name in fitted.names]
    moments = np.stack(columns, axis=1)
    # The deflection is moments @ values; its standard deviation is the length of the reduced vector.
    # Without its mean over the readings: that part is an offset of the joint, and no sign of a spring.
    reduced = np.linalg.qr(moments - moments.mean(axis=0), mode="r") / np.sqrt(len(moments))
    deflection, spread = norm_with_uncertainty(
        reduced @ fitted.values, reduced @ fitted.covariance @ reduced.T
    )
    deflection_deg, spread_deg = float(np.rad2deg(deflection)), float(np.rad2deg(spread))
    sentence = message("causes.compliance.products", joint=subject, deflection_deg=deflection_deg)
    return Description(subject, deflection_deg, "deg", spread_deg, sentence)


def _deflection(name: str, rows: Rows) -> tuple[Port, FloatArray]:
    """Return the port and weight (n,) of one parameter."""
    joint = _sprung_joint(name)
    port = Port(PortKind.THETA, joint)
    # Products are linear in the frames of the arm and not in a torque: nobody knows the torque.
    if "*" in name:
        return port, _regressor(name, rows.chain, rows.gravity_m_s2)
    return port, known_torque(rows, joint)


def known_torque(rows: Rows, joint: int) -> FloatArray:
    """Return the torque about a joint.

    Parameters
    ----------
    rows : Rows
    joint : int
        0-based.

    Returns
    -------
    ndarray, shape (n,)
        [N mm]; 0 where it is unknown.
    """
    if rows.torque_n_mm is None:
        return np.zeros(len(rows.stops))
    torque = rows.torque_n_mm[:, joint]
    # A row that lacks its torque is fitted without a deflection there, rather than not at all.
    return np.where(np.isnan(torque), 0.0, torque)


def _regressor(name: str, chain: Chain, gravity_m_s2: FloatArray) -> FloatArray:
    """Return the torque per first moment of mass of a product such as `c_2*mx_4`, shape (n,)."""
    spring, _, moment = name.partition("*")
    return moment_regressor(chain, joint_of(spring), joint_of(moment), "xy".index(moment[1]), gravity_m_s2)


def _idle_spring(joint: int, largest_rad: float, setting: Setting) -> NotIdentifiable:
    key = "open.spring_upright" if joint == 0 and _is_upright(setting) else "open.spring_idle"
    reason = message(key, joint=joint + 1, largest_rad=largest_rad)
    return NotIdentifiable((joint_name("c", joint),), reason)
