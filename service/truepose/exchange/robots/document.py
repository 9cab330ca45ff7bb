"""The nominal robot, frames and nests as keys of a document; campaign, model and robot files share them.

Documents say degrees; the domain says radians.
"""

import math
from collections.abc import Sequence

from truepose.domain.robot import FramePlacement, JointRange, JointRow, LinkMass, Nest, Robot
from truepose.exchange.document import Node
from truepose.exchange.errors import WrongUnitError
from truepose.exchange.json_text import Json

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
        joint.fail(f"joint {joint.whole()} stands in row {number}; rows are numbered 1, 2, ... in order")
    sign = row.optional("sign")
    if sign is not None and sign.whole() not in {-1, 1}:
        sign.fail("the sign of a joint must be 1 or -1")
    return JointRow(
        alpha_rad=math.radians(row.key("alpha_deg").number()),
        a_mm=row.key("a_mm").number(),
        theta_offset_rad=math.radians(row.key("theta_offset_deg").number()),
        d_mm=row.key("d_mm").number(),
        sign=1 if sign is None else sign.whole(),
    )


def joints_document(joints: Sequence[JointRow]) -> list[Json]:
    """Return the rows of `dhm_nominal`."""
    return [
        {
            "joint": number,
            "alpha_deg": degrees(row.alpha_rad),
            "a_mm": row.a_mm,
            "theta_offset_deg": degrees(row.theta_offset_rad),
            "d_mm": row.d_mm,
            "sign": row.sign,
        }
        for number, row in enumerate(joints, start=1)
    ]


def read_masses(node: Node, n_joints: int) -> tuple[LinkMass, ...]:
    """Read `masses`: `frame, kg, cog_mm` per link."""
    return tuple(
        LinkMass(
            frame=entry.key("frame").whole(least=1, greatest=n_joints),
            mass_kg=entry.key("kg").number(least=0.0),
            centre_of_gravity_mm=entry.key("cog_mm").vector(),
        )
        for entry in node.items()
    )


def masses_document(masses: Sequence[LinkMass]) -> list[Json]:
    """Return the entries of `masses`."""
    return [{"frame": m.frame, "kg": m.mass_kg, "cog_mm": list(m.centre_of_gravity_mm)} for m in masses]


def read_optional_numbers(node: Node | None, count: int) -> tuple[float, ...] | None:
    """Read a list of `count` positive numbers, or None where the key is absent."""
    return None if node is None else tuple(entry.number(above=0.0) for entry in node.items(count))


def read_ranges(node: Node | None, n_joints: int) -> tuple[JointRange, ...] | None:
    """Read pairs of degrees, lower and upper, one per joint; None where the key is absent."""
    return None if node is None else tuple(_read_range(entry) for entry in node.items(n_joints))


def _read_range(node: Node) -> JointRange:
    lower, upper = node.numbers(2)
    if lower >= upper:
        node.fail(f"the lower limit {lower:g} is not below the upper limit {upper:g}")
    return JointRange(math.radians(lower), math.radians(upper))


def ranges_document(ranges: Sequence[JointRange] | None) -> Json:
    """Return pairs of degrees, or null."""
    return None if ranges is None else [[degrees(r.lower_rad), degrees(r.upper_rad)] for r in ranges]


def read_placement(node: Node) -> FramePlacement:
    """Read `x_mm y_mm z_mm rx_deg ry_deg rz_deg`."""
    return FramePlacement(
        *(node.key(name).number() for name in ("x_mm", "y_mm", "z_mm")),
        *(math.radians(node.key(name).number()) for name in ("rx_deg", "ry_deg", "rz_deg")),
    )


def placement_document(placement: FramePlacement) -> dict[str, Json]:
    """Return the six keys of a placement."""
    return {
        "x_mm": placement.x_mm,
        "y_mm": placement.y_mm,
        "z_mm": placement.z_mm,
        "rx_deg": degrees(placement.rx_rad),
        "ry_deg": degrees(placement.ry_rad),
        "rz_deg": degrees(placement.rz_rad),
    }


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


def read_robot(node: Node, name: str, joints: tuple[JointRow, ...]) -> Robot:
    """Read a whole nominal robot from the keys of `robot_document`."""
    n = len(joints)
    payload = node.optional("rated_payload_kg")
    source = node.optional("source")
    return Robot(
        name=name,
        joints=joints,
        masses=read_masses(node.key("masses"), n),
        gear_ratios=read_optional_numbers(node.optional("gear_ratio"), n),
        typical_compliances_rad_per_n_mm=read_optional_numbers(
            node.optional("typical_compliance_rad_per_Nmm"), n
        ),
        repeatability_mm=node.key("robot_repeatability_mm").number(least=0.0),
        calibration_ranges=read_ranges(node.optional("calibration_ranges_deg"), n),
        rated_payload_kg=None if payload is None else payload.number(above=0.0),
        source="" if source is None else source.text(),
        joint_limits=read_ranges(node.optional("joint_limits_deg"), n),
    )


def robot_document(robot: Robot) -> dict[str, Json]:
    """Return the whole nominal robot as keys of a document."""
    return {
        "name": robot.name,
        "dhm_nominal": joints_document(robot.joints),
        "masses": masses_document(robot.masses),
        "gear_ratio": optional_list(robot.gear_ratios),
        "typical_compliance_rad_per_Nmm": optional_list(robot.typical_compliances_rad_per_n_mm),
        "robot_repeatability_mm": robot.repeatability_mm,
        "calibration_ranges_deg": ranges_document(robot.calibration_ranges),
        "joint_limits_deg": ranges_document(robot.joint_limits),
        "rated_payload_kg": robot.rated_payload_kg,
        "source": robot.source or None,
    }


def read_nest(entry: Node) -> Nest:
    """Read a tool nest from a table with `centre_mm`, and `u_mm`, `facing` where known."""
    uncertainty = entry.optional("u_mm")
    return Nest(
        centre_mm=entry.key("centre_mm").vector(),
        standard_uncertainty_mm=None if uncertainty is None else uncertainty.number(least=0.0),
        facing=read_direction(entry.optional("facing")),
    )


def optional_list(numbers: Sequence[float] | None) -> Json:
    """Return the numbers as a list, or null."""
    return None if numbers is None else list(numbers)


def degrees(angle_rad: float) -> float:
    """Return an angle in degrees with 15 significant digits.

    The conversion there and back is off in the 16th digit; without the rounding a table of round
    numbers would come back as 33.00000000000001. What is lost is 5e-16 of the value.
    """
    return float(f"{math.degrees(angle_rad):.15g}")
