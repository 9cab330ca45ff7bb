"""pybotics: its own forward kinematics, and an identification through its optimisation handler.

Runs in an environment of its own: `pybotics_peer.py ARRAYS.npz` prints times [s] as JSON.
"""

import json
import sys

import numpy as np
from pybotics.kinematic_chain import MDHKinematicChain
from pybotics.optimization import OptimizationHandler, optimize_accuracy
from pybotics.robot import Robot
from pybotics.tool import Tool
from repeated import timed
from scipy.optimize import least_squares


def _robot(arrays):
    tool = np.eye(4)
    tool[:3, 3] = arrays["tool"]
    robot = Robot(kinematic_chain=MDHKinematicChain(arrays["table"]))
    robot.tool = Tool(matrix=tool)
    return robot


def _identify(arrays, n):
    handler = OptimizationHandler(
        _robot(arrays),
        kinematic_chain_mask=arrays["free"].ravel().tolist(),
        tool_mask=[True] * 3 + [False] * 3,
        world_mask=[True] * 6,
    )
    least_squares(
        optimize_accuracy,
        handler.generate_optimization_vector(),
        args=(handler, arrays[f"joints_{n}"], arrays[f"measured_{n}"]),
    )


def main():
    """Print the times."""
    arrays = np.load(sys.argv[1])
    robot = _robot(arrays)
    found = {"forward kinematics 10000": timed(lambda: [robot.fk(q) for q in arrays["joints_10000"]])}
    for n in (50, 1000):
        found[f"bare solution {n}"] = timed(lambda n=n: _identify(arrays, n))
    sys.stdout.write(json.dumps(found))


main()
