"""roboticstoolbox-python: its forward kinematics; it has no identification.

Runs in an environment of its own: `roboticstoolbox_peer.py ARRAYS.npz` prints times [s] as JSON.
"""

import json
import sys

import numpy as np
import roboticstoolbox
from repeated import timed


def main():
    """Print the times."""
    arrays = np.load(sys.argv[1])
    links = [
        roboticstoolbox.RevoluteMDH(alpha=alpha, a=a / 1e3, offset=theta, d=d / 1e3)
        for alpha, a, theta, d in arrays["table"]
    ]
    robot = roboticstoolbox.DHRobot(links)
    found = timed(lambda: robot.fkine(arrays["joints_10000"]))
    sys.stdout.write(json.dumps({"forward kinematics 10000": found}))


main()
