"""The arms that the simulated cells can have, read off the makers' drawings and data sheets.

Sources: ABB, "Product specification IRB 120", 3HAC035960 (working range, dimensions, axis speeds);
FANUC, "LR Mate 200iC" data sheet (dimensions, motion range, speeds); Universal Robots, UR10 data sheet and
"DH parameters for calculations of kinematics and dynamics" (dimensions, masses); of the KR 6 the axes, ranges
and speeds of ros-industrial/kuka_experimental, kr6r900sixx_macro.xacro. Other masses and places of
the centres of gravity: A. Nubiola, thesis, ETS Montreal 2014, section 2.3, moved into the base frame by hand.
No maker states compliances, few state gear ratios; these are typical of gearboxes of that size.
"""

import math
from collections.abc import Mapping
from types import MappingProxyType

from truepose_simulators.physics.arm import Arm, CarriedMass, JointAxis, Vector

_UP: Vector = (0.0, 0.0, 1.0)
_FORWARD: Vector = (1.0, 0.0, 0.0)
_BACKWARD: Vector = (-1.0, 0.0, 0.0)
_DOWN: Vector = (0.0, 0.0, -1.0)
_LEFT: Vector = (0.0, 1.0, 0.0)
_RIGHT: Vector = (0.0, -1.0, 0.0)


def _joint(
    point_mm: Vector, direction: Vector, normal: Vector, range_deg: tuple[float, float], speed_deg_s: float
) -> JointAxis:
    lower, upper = (math.radians(limit) for limit in range_deg)
    return JointAxis(point_mm, direction, normal, lower, upper, math.radians(speed_deg_s))


# Shoulder 290 above the floor, upper arm 270 straight up, wrist line 70 above the elbow, wrist centre
# 302 in front of it, flange 72 further on.
_IRB120 = Arm(
    name="irb120",
    model="IRB 120-3/0.6",
    joints=(
        _joint((0.0, 0.0, 290.0), _UP, _FORWARD, (-165.0, 165.0), 250.0),
        _joint((0.0, 0.0, 290.0), _LEFT, _FORWARD, (-110.0, 110.0), 250.0),
        _joint((0.0, 0.0, 560.0), _LEFT, _UP, (-110.0, 70.0), 250.0),
        _joint((302.0, 0.0, 630.0), _FORWARD, _UP, (-160.0, 160.0), 320.0),
        _joint((302.0, 0.0, 630.0), _LEFT, _UP, (-120.0, 120.0), 320.0),
        _joint((374.0, 0.0, 630.0), _FORWARD, _UP, (-400.0, 400.0), 420.0),
    ),
    masses=(CarriedMass(2, 4.2, (0.0, 0.0, 430.0)), CarriedMass(4, 5.0, (108.4, 0.0, 630.0))),
    flange_mm=(374.0, 0.0, 630.0),
    flange_x=_DOWN,  # the controller's flange frame is turned by half a turn
    flange_z=_FORWARD,
    typical_compliance_rad_per_n_mm=(0.02e-6, 0.032e-6, 0.130e-6, 0.605e-6, 0.419e-6, 0.647e-6),
    gear_ratio=(121.0, 121.0, 101.0, 50.0, 51.0, 50.0),
)

# Shoulder 75 in front of axis 1 and 330 above the floor, upper arm 300, wrist line 75 above the elbow,
# wrist centre 320 in front, flange 80 further on. The maker states the range of joint 3 as 388 deg in
# all and couples it to joint 2; here it is taken half to each side.
_LRMATE = Arm(
    name="lrmate200ic",
    model="LR Mate 200iC",
    joints=(
        _joint((0.0, 0.0, 330.0), _UP, _FORWARD, (-170.0, 170.0), 350.0),
        _joint((75.0, 0.0, 330.0), _LEFT, _FORWARD, (-60.0, 140.0), 350.0),
        _joint((75.0, 0.0, 630.0), _LEFT, _UP, (-194.0, 194.0), 400.0),
        _joint((395.0, 0.0, 705.0), _FORWARD, _UP, (-190.0, 190.0), 450.0),
        _joint((395.0, 0.0, 705.0), _LEFT, _UP, (-120.0, 120.0), 450.0),
        _joint((475.0, 0.0, 705.0), _FORWARD, _UP, (-360.0, 360.0), 720.0),
    ),
    masses=(CarriedMass(2, 10.0, (75.0, 0.0, 480.0)), CarriedMass(4, 10.0, (235.0, 0.0, 705.0))),
    flange_mm=(475.0, 0.0, 705.0),
    flange_x=_UP,
    flange_z=_FORWARD,
    typical_compliance_rad_per_n_mm=(0.015e-6, 0.022e-6, 0.06e-6, 0.30e-6, 0.30e-6, 0.40e-6),
    gear_ratio=(115.0, 120.0, 110.0, 80.0, 80.0, 50.0),
)

# Lying along -x: shoulder 127.3 above the floor, upper arm 612, forearm 572.3, wrist 163.941 to the right,
# 115.7 down, flange 92.2 further to the right. Axes 2 to 4 point to the right.
_UR10 = Arm(
    name="ur10",
    model="UR10",
    joints=(
        _joint((0.0, 0.0, 127.3), _UP, _FORWARD, (-360.0, 360.0), 120.0),
        _joint((0.0, 0.0, 127.3), _RIGHT, _FORWARD, (-360.0, 360.0), 120.0),
        _joint((-612.0, 0.0, 127.3), _RIGHT, _FORWARD, (-360.0, 360.0), 180.0),
        _joint((-1184.3, -163.941, 127.3), _RIGHT, _FORWARD, (-360.0, 360.0), 180.0),
        _joint((-1184.3, -163.941, 11.6), _DOWN, _FORWARD, (-360.0, 360.0), 180.0),
        _joint((-1184.3, -256.141, 11.6), _RIGHT, _FORWARD, (-360.0, 360.0), 180.0),
    ),
    masses=(
        CarriedMass(1, 7.1, (21.0, -27.0, 127.3)),
        CarriedMass(2, 12.7, (-232.0, -158.0, 127.3)),
        CarriedMass(3, 4.27, (-944.3, -68.0, 127.3)),
        CarriedMass(4, 2.0, (-1184.3, -170.941, 109.3)),
        CarriedMass(5, 2.0, (-1184.3, -181.941, 18.6)),
        CarriedMass(6, 0.365, (-1184.3, -230.141, 11.6)),
    ),
    flange_mm=(-1184.3, -256.141, 11.6),
    flange_x=_FORWARD,
    flange_z=_RIGHT,
    typical_compliance_rad_per_n_mm=(0.02e-6, 0.02e-6, 0.035e-6, 0.12e-6, 0.12e-6, 0.12e-6),
    gear_ratio=(101.0, 101.0, 101.0, 101.0, 101.0, 101.0),
)

# Stretched forward: shoulder 25 in front of axis 1 and 400 above the floor, upper arm 455, wrist line 35
# above the elbow, wrist centre 420 further on, flange 80. Axes 1, 4 and 6 point down or back. The maker
# states 52 kg in all and no masses of links; those here are guessed.
_KR6 = Arm(
    name="kr6r900",
    model="KR 6 R900 sixx",
    joints=(
        _joint((0.0, 0.0, 400.0), _DOWN, _FORWARD, (-170.0, 170.0), 360.0),
        _joint((25.0, 0.0, 400.0), _LEFT, _FORWARD, (-190.0, 45.0), 300.0),
        _joint((480.0, 0.0, 400.0), _LEFT, _FORWARD, (-120.0, 156.0), 360.0),
        _joint((900.0, 0.0, 435.0), _BACKWARD, _UP, (-185.0, 185.0), 381.0),
        _joint((900.0, 0.0, 435.0), _LEFT, _UP, (-120.0, 120.0), 388.0),
        _joint((980.0, 0.0, 435.0), _BACKWARD, _UP, (-350.0, 350.0), 615.0),
    ),
    masses=(CarriedMass(2, 8.0, (250.0, 0.0, 400.0)), CarriedMass(4, 9.0, (650.0, 0.0, 435.0))),
    flange_mm=(980.0, 0.0, 435.0),
    flange_x=_DOWN,
    flange_z=_FORWARD,
    typical_compliance_rad_per_n_mm=(0.015e-6, 0.02e-6, 0.06e-6, 0.30e-6, 0.30e-6, 0.40e-6),
    gear_ratio=(100.0, 100.0, 100.0, 80.0, 80.0, 50.0),
)

ARMS: Mapping[str, Arm] = MappingProxyType({arm.name: arm for arm in (_IRB120, _LRMATE, _UR10, _KR6)})
