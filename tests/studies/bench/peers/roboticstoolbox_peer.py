"""roboticstoolbox-python: its forward kinematics; it has no identification.

Runs in an environment of its own: `roboticstoolbox_peer.py ARRAYS.npz` prints medians [s] as JSON.
"""

import json
import sys
import time
from statistics import median

import numpy as np
import roboticstoolbox


def main():
    """Print the times."""
    arrays = np.load(sys.argv[1])
    links = [
        roboticstoolbox.RevoluteMDH(alpha=alpha, a=a / 1e3, offset=theta, d=d / 1e3)
        for alpha, a, theta, d in arrays["table"]
    ]
    robot, taken = roboticstoolbox.DHRobot(links), []
    for _ in range(3):
        start = time.perf_counter()
        robot.fkine(arrays["joints_10000"])
        taken.append(time.perf_counter() - start)
    found = {"forward kinematics 10000": {"median_s": median(taken), "runs": len(taken)}}
    sys.stdout.write(json.dumps(found))


main()
