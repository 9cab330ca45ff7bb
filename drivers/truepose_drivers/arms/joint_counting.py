"""How a FANUC controller counts its joints, and how the robot file does.

The controller counts joint 3 from the horizontal, upwards, and joint 2 forwards: while joint 2 alone moves
the forearm keeps its inclination. Counted from the upper arm, in the controller's own direction, joint 3 is

    j_3 = J_3 + J_2

The other joints are independent. Which way round each joint is counted is a matter of signs.

Sources: measurements on a CRX (package airo-fanuc) and on an ER-4iA in FANUC's own simulator (package
fanuc-python); signs of the LR Mate 200iC: the axes of ros-industrial/fanuc, fanuc_lrmate200ic_support.
"""

from dataclasses import dataclass
from typing import Final

Angles = tuple[float, ...]

# The shipped table of the LR Mate turns joints 3 to 6 the other way round than its controller.
LR_MATE_SIGNS: Final = (1, 1, -1, -1, -1, -1)


@dataclass(frozen=True, slots=True)
class JointCounting:
    """What turns angles of the controller into those of the robot file; any unit."""

    signs: tuple[int, ...] = LR_MATE_SIGNS  # -1 where the robot file counts the other way round
    from_horizontal: bool = True  # False: the controller counts joint 3 from the upper arm

    def of_robot(self, shown: Angles) -> Angles:
        """Return the angles of the robot file of what the controller shows."""
        first, second, third, *others = shown
        own = (first, second, third + (second if self.from_horizontal else 0.0), *others)
        return self._signed(own)

    def of_controller(self, joints: Angles) -> Angles:
        """Return what the controller shows of angles of the robot file."""
        first, second, third, *others = self._signed(joints)
        return (first, second, third - (second if self.from_horizontal else 0.0), *others)

    def inclined(self, shown: Angles) -> Angles:
        """Return what the controller shows, with the forearm's inclination for joint 3 in any case."""
        first, second, third, *others = shown
        return (first, second, third - (0.0 if self.from_horizontal else second), *others)

    def _signed(self, angles: Angles) -> Angles:
        return tuple(sign * angle for sign, angle in zip(self.signs, angles, strict=True))
