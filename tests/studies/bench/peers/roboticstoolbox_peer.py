"""roboticstoolbox-python: its forward kinematics; it has no identification.

Runs in an environment of its own: `roboticstoolbox_peer.py ARRAYS.npz` prints times [s] as JSON.
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
    robot, taken, busy = roboticstoolbox.DHRobot(links), [], []
    for _ in range(3):
        start, before = time.perf_counter(), time.process_time()
        robot.fkine(arrays["joints_10000"])
        taken.append(time.perf_counter() - start)
        busy.append(time.process_time() - before)
    found = {
        "median_s": median(taken),
        "runs": len(taken),
        "cpu_s": median(busy),
        "least_cpu_s": min(busy),
    }
    sys.stdout.write(json.dumps({"forward kinematics 10000": found}))


main()
