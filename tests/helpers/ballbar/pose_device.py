"""The pose device as the thesis built it: nominal base fixture, tool nests, lengths of legs."""

import numpy as np

from truepose.kinematics.pose_device import assemblies, base_triangle, fourth_cup, measurable

# Tool nests in the flange frame: thesis section 2.2.1 and Annex I; nest 1 on axis 6.
NESTS = np.array([[0.0, 0.0, 125.0], [75.0, 93.675, 215.0], [150.0, 0.0, 125.0]])
CUPS = base_triangle(300.0, 300.0, 300.0)
FOUR_CUPS = np.vstack([CUPS, fourth_cup(CUPS, 300.0, 300.0, 300.0)])
SIGMA_MM = 0.00051  # QC20-W: 2 um at 95 %
ALL = assemblies(CUPS, NESTS)
MEASURABLE = measurable(ALL, CUPS, NESTS)
ALL_LEGS = tuple((cup, nest) for cup in (1, 2, 3) for nest in (1, 2, 3))


def lengths(pose, legs, cups=CUPS, nests=NESTS):
    """Return true lengths of legs at a pose."""
    placed = pose.points(nests)
    return np.array([np.linalg.norm(placed[nest - 1] - cups[cup - 1]) for cup, nest in legs])
