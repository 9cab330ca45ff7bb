"""figaroh: the frames of its backend (pinocchio), and its calibration of every link, the base and the tip.

Runs in an environment of its own: `figaroh_peer.py ARRAYS.npz` prints times [s] as JSON.
"""

import json
import logging
import sys
import tempfile
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio
from figaroh.calibration.base_calibration import BaseCalibration
from figaroh.calibration.calibration_tools import calc_updated_fkm
from repeated import timed

_M_PER_MM = 1e-3
_LIMIT = '<limit lower="-7" upper="7" effort="1" velocity="1"/>'  # none that matters
_JOINTS = [f"joint{number}" for number in range(1, 7)]


class _Calibration(BaseCalibration):
    """The residuals that figaroh leaves to its user: positions, base and tip unknown."""

    def __init__(self, robot, file):
        super().__init__(robot, file)
        self.calib_config.update(known_baseframe=False, known_tipframe=False)

    def cost_function(self, values):
        predicted = calc_updated_fkm(self.model, self.data, values, self.q_measured, self.calib_config)
        return self.PEE_measured - predicted


def _origin(rotation, shift_mm):
    shift = " ".join(map(str, _M_PER_MM * shift_mm))
    angles = " ".join(map(str, pinocchio.rpy.matrixToRpy(rotation)))
    return f'<origin xyz="{shift}" rpy="{angles}"/>'


def _description(arrays):
    """Return the arm as URDF: what stands before each joint's own turn."""
    parts = ['<robot name="arm"><link name="link0"/>']
    for number, (alpha, a, theta, d) in enumerate(arrays["table"], start=1):
        tilt = pinocchio.utils.rotate("x", alpha)
        parts.append(
            f'<link name="link{number}"/><joint name="joint{number}" type="revolute"><axis xyz="0 0 1"/>'
            f'<parent link="link{number - 1}"/><child link="link{number}"/>{_LIMIT}'
            + _origin(tilt @ pinocchio.utils.rotate("z", theta), np.array([a, 0.0, 0.0]) + d * tilt[:, 2])
            + "</joint>"
        )
    tip = _origin(np.eye(3), arrays["tool"])
    parts.append('<link name="tip"/><joint name="tip_joint" type="fixed"><parent link="link6"/>')
    return "".join([*parts, f'<child link="tip"/>{tip}</joint></robot>'])


def _robot(arrays):
    model = pinocchio.buildModelFromXML(_description(arrays))
    return SimpleNamespace(
        model=model,
        data=model.createData(),
        q0=pinocchio.neutral(model),
        visual_model=None,
        collision_model=None,
    )


def _written(arrays, n, folder):
    """Write the readings and what figaroh is to do with them; returns the file (JSON is YAML)."""
    readings, task = folder / f"readings_{n}.csv", folder / f"task_{n}.yaml"
    rows = np.hstack([_M_PER_MM * arrays[f"measured_{n}"], arrays[f"joints_{n}"]])
    header = ",".join(["x1", "y1", "z1", *_JOINTS])
    np.savetxt(readings, rows, delimiter=",", header=header, comments="")
    joints = {"active_joints": _JOINTS}
    calibration = {
        "enabled": True,
        "type": "kinematic_calibration",
        "joints": joints,
        "kinematics": {"base_frame": "universe", "tool_frame": "tip"},
        "parameters": {
            "calibration_level": "full_params",
            "include_non_geometric": False,
            "outlier_threshold": 1.0,  # m: none
        },
        "measurements": {
            "markers": [{"ref_joint": _JOINTS[-1], "measurable_dof": [True] * 3 + [False] * 3}],
            "poses": {"base_pose": None, "tool_pose": None},
        },
        "data": {"number_of_samples": n, "source_file": str(readings)},
    }
    document = {
        "meta": {"schema_version": "2.0", "config_type": "robot_configuration"},
        "robot": {"name": "arm", "properties": {"joints": joints}},
        "tasks": {"calibration": calibration},
    }
    task.write_text(json.dumps(document))
    return task


def _identify(arrays, task):
    calibration = _Calibration(_robot(arrays), str(task))
    calibration.initialize()
    calibration.solve(enable_logging=False)
    return calibration


def _frames(robot, joints):
    tip = robot.model.getFrameId("tip")
    places = np.empty((len(joints), 3))
    for row, angles in enumerate(joints):
        pinocchio.framesForwardKinematics(robot.model, robot.data, angles)
        places[row] = robot.data.oMf[tip].translation
    return places / _M_PER_MM


def main():
    """Print the times."""
    logging.disable(logging.CRITICAL)
    arrays = np.load(sys.argv[1])
    robot = _robot(arrays)
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        found = {"forward kinematics 10000": timed(lambda: _frames(robot, arrays["joints_10000"]))}
        for n in (50, 1000):
            task = _written(arrays, n, Path(folder))
            found[f"bare solution {n}"] = timed(lambda task=task: _identify(arrays, task))
    sys.stdout.write(json.dumps(found))


main()
