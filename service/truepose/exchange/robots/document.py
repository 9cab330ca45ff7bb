"""Robot, frames, nests and covariances as keys of a document; campaign, model and robot files share them.

Documents say degrees; the domain says radians.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, JointRange, JointRow, LinkMass, Nest, Robot
from truepose.exchange.document import (
    ANGLE,
    NUMBER,
    VECTOR,
    Form,
    Key,
    Node,
    degrees,
    each,
    number,
    read_keys,
    record,
    whole,
    written_keys,
)
from truepose.exchange.errors import WrongUnitError
from truepose.exchange.json_text import Json, number_or_null

# Relative to the standard deviations: far above the rounding of products, far below a typing error.
_TOLERANCE = 1e-9
_FEW_DIGITS = 1e-3  # of a variance: below 0 by more than other programs round to


def read_covariance(node: Node, size: int) -> FloatArray:
    """Read a covariance, shape (size, size); null entries are NaN.

    Raises BadValueError for one that is not symmetric, or has a negative variance or a correlation above 1.
    """
    rows = [
        [math.nan if entry.is_null else entry.number() for entry in row.items(size)]
        for row in node.items(size)
    ]
    covariance: FloatArray = np.array(rows, float).reshape(size, size)
    variances = np.nan_to_num(np.diag(covariance))
    if np.any(variances < 0.0):
        node.fail("a covariance must not have negative variances")
    deviations = np.sqrt(variances)
    scale = np.outer(deviations, deviations)
    # An entry that is known on one side of the diagonal only is refused: of NaN every comparison is false.
    known = ~np.isnan(covariance) | ~np.isnan(covariance.T)
    asymmetry = np.abs(covariance - covariance.T)
    if np.any(known & ~(asymmetry <= _TOLERANCE * scale)):
        node.fail("a covariance must be symmetric")
    if np.any(np.abs(np.nan_to_num(covariance)) > (1.0 + _TOLERANCE) * scale):
        node.fail("a covariance must not have correlations beyond 1")
    if _least_variance(covariance, deviations) < -_FEW_DIGITS:
        node.fail("a covariance must not have negative variances, nor may any combination of its parameters")
    return covariance


def _least_variance(covariance: FloatArray, deviations: FloatArray) -> float:
    """Return the least variance of any combination, in units of the standard deviations; 0 if unknown."""
    known = deviations > 0.0
    unit = covariance[np.ix_(known, known)] / np.outer(deviations[known], deviations[known])
    return float(np.linalg.eigvalsh(unit)[0]) if unit.size and np.isfinite(unit).all() else 0.0


def covariance_document(covariance: FloatArray) -> Json:
    """Return the rows as lists, null for what is not finite."""
    return [[number_or_null(entry) for entry in row] for row in covariance.tolist()]


_UNIT_LENGTH_TOLERANCE = 1e-3  # directions are given with three decimals at least
_ROUNDING = 1e-14  # of a unit vector in full precision, which is left as it is
_GREATEST_GRAVITY_M_S2 = 20.0  # twice the Earth's: beyond it the unit is another one


def read_joints(node: Node) -> tuple[JointRow, ...]:
    """Read `dhm_nominal`: one row per joint, numbered 1..n in order."""
    rows = node.items()
    if not rows:
        node.fail("the table has no rows; one per joint is required")
    return tuple(_read_joint(row, number) for number, row in enumerate(rows, start=1))


def _read_joint(row: Node, number: int) -> JointRow:
    joint = row.key("joint")
    if joint.whole() != number:
        joint.fail(f"joint {joint.whole()} is in row {number}; rows are numbered 1, 2, ... in order")
    return JointRow(**read_keys(row, [*_JOINT, _TILT]))


def _read_sign(node: Node) -> int:
    if node.whole() not in {-1, 1}:
        node.fail("the sign of a joint must be 1 or -1")
    return node.whole()


_JOINT: Final = (
    Key("alpha_deg", "alpha_rad", ANGLE),
    Key("a_mm", "a_mm", NUMBER),
    Key("theta_offset_deg", "theta_offset_rad", ANGLE),
    Key("d_mm", "d_mm", NUMBER),
    Key("sign", "sign", Form(_read_sign), absent=1),
)
_TILT: Final = Key("beta_deg", "beta_rad", ANGLE, absent=0.0)  # written where there is one


def joints_document(joints: Sequence[JointRow]) -> list[Json]:
    """Return the rows of `dhm_nominal`."""
    return [
        {"joint": number, **written_keys(row, [*_JOINT, _TILT] if row.beta_rad else _JOINT)}
        for number, row in enumerate(joints, start=1)
    ]


PLACEMENT: Final = record(
    FramePlacement,
    [
        *(Key(name, name, NUMBER) for name in ("x_mm", "y_mm", "z_mm")),
        *(Key(f"{name}_deg", f"{name}_rad", ANGLE) for name in ("rx", "ry", "rz")),
    ],
)


def arm_keys(n_joints: int) -> list[Key]:
    """Return the keys that campaigns, models and robot files say of an arm besides its table."""
    mass = record(
        LinkMass,
        [
            Key("frame", "frame", whole(least=1, greatest=n_joints)),
            Key("kg", "mass_kg", number(least=0.0)),
            Key("cog_mm", "centre_of_gravity_mm", VECTOR),
        ],
    )
    positive = each(number(above=0.0), n_joints)
    compliances = "typical_compliances_rad_per_n_mm"
    return [
        Key("masses", "masses", each(mass)),
        Key("gear_ratio", "gear_ratios", positive, absent=None),
        Key("typical_compliance_rad_per_Nmm", compliances, positive, absent=None),
        Key("robot_repeatability_mm", "repeatability_mm", number(least=0.0)),
    ]


def ranges_of(n_joints: int) -> Form:
    """Return the form of pairs of degrees, lower and upper, one per joint."""
    return each(Form(_read_range, lambda r: [degrees(r.lower_rad), degrees(r.upper_rad)]), n_joints)


def _robot_keys(n_joints: int) -> list[Key]:
    ranges = ranges_of(n_joints)
    return [
        *arm_keys(n_joints),
        Key("calibration_ranges_deg", "calibration_ranges", ranges, absent=None),
        Key("joint_limits_deg", "joint_limits", ranges, absent=None),
        Key("rated_payload_kg", "rated_payload_kg", number(above=0.0), absent=None),
        Key("source", "source", Form(Node.text, lambda text: text or None), absent=""),
    ]


def _read_range(node: Node) -> JointRange:
    lower, upper = node.numbers(2)
    if lower >= upper:
        node.fail(f"the lower limit {lower:g} is not below the upper limit {upper:g}")
    return JointRange(math.radians(lower), math.radians(upper))


def read_gravity(node: Node) -> tuple[float, float, float]:
    """Read a gravity vector [m/s2]."""
    gravity = node.vector()
    if math.hypot(*gravity) > _GREATEST_GRAVITY_M_S2:
        node.fail("no place on Earth has this gravity; it is given in m/s2", WrongUnitError)
    return gravity


def read_direction(node: Node | None) -> tuple[float, float, float] | None:
    """Read a unit vector and bring it to unit length exactly; None where absent."""
    if node is None or node.is_null:
        return None
    x, y, z = node.vector()
    length = math.sqrt(x * x + y * y + z * z)
    if abs(length - 1.0) > _UNIT_LENGTH_TOLERANCE:
        node.fail(f"the vector has the length {length:g}; a unit vector is required")
    if abs(length - 1.0) < _ROUNDING:
        return (x, y, z)
    return (x / length, y / length, z / length)


GRAVITY: Final = Form(read_gravity, list)


def read_robot(node: Node, name: str, joints: tuple[JointRow, ...]) -> Robot:
    """Read a whole nominal robot from the keys of `robot_document`."""
    return Robot(name=name, joints=joints, **read_keys(node, _robot_keys(len(joints))))


def robot_document(robot: Robot) -> dict[str, Json]:
    """Return the whole nominal robot as keys of a document."""
    table = joints_document(robot.joints)
    return {"name": robot.name, "dhm_nominal": table, **written_keys(robot, _robot_keys(robot.n_joints))}


ROBOT: Final = Form(
    lambda node: read_robot(node, node.key("name").text(), read_joints(node.key("dhm_nominal"))),
    robot_document,
)


_NEST: Final = (
    Key("centre_mm", "centre_mm", VECTOR),
    Key("u_mm", "standard_uncertainty_mm", number(least=0.0), absent=None),
    Key("facing", "facing", Form(read_direction), absent=None),
)


def read_nest(entry: Node) -> Nest:
    """Read a tool nest from a table with `centre_mm`, and `u_mm`, `facing` where known."""
    return Nest(**read_keys(entry, _NEST))
