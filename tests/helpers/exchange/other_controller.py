"""Controllers by another route than the product's: plain matrices, a triangle, and a wrist of three angles.

Nothing of the product's kinematics is used, only the numbers of a robot's table. Poses are those of the last
frame in the base; every function takes n of them.
"""

import itertools

import numpy as np

QUARTER = np.pi / 2
FULL = 2 * np.pi


def transform(robot, joints, first=0, last=6):
    """Product of RotX TransX RotZ TransZ of some rows, shape (n, 4, 4)."""
    found = np.tile(np.eye(4), (len(joints), 1, 1))
    for at in range(first, last):
        row = robot.joints[at]
        theta = row.sign * joints[:, at] + row.theta_offset_rad
        ca, sa, c, s = np.cos(row.alpha_rad), np.sin(row.alpha_rad), np.cos(theta), np.sin(theta)
        one = np.zeros((len(joints), 4, 4))
        one[:, 0, 0], one[:, 0, 1], one[:, 0, 3] = c, -s, row.a_mm
        one[:, 1, 0], one[:, 1, 1], one[:, 1, 2], one[:, 1, 3] = s * ca, c * ca, -sa, -sa * row.d_mm
        one[:, 2, 0], one[:, 2, 1], one[:, 2, 2], one[:, 2, 3] = s * sa, c * sa, ca, ca * row.d_mm
        one[:, 3, 3] = 1.0
        found = found @ one
    return found


def posture(robot, joints):
    """Whether the wrist is behind axis 1, behind the lower arm, and joint 5 negative, shape (n, 3)."""
    first, second, third = (transform(robot, joints, 0, k) for k in (1, 2, 3))
    wrist = transform(robot, joints, 0, 4)[:, :3, 3]
    ahead = np.einsum("ni,ni->n", wrist - first[:, :3, 3], first[:, :3, 0])
    return np.stack([ahead < 0, _bend(second, third, wrist) < 0, joints[:, 4] < 0], axis=1)


def _bend(second, third, wrist):
    """The angle from the upper arm to the forearm, about axis 2."""
    upper, fore = third[:, :3, 3] - second[:, :3, 3], wrist - third[:, :3, 3]
    turn = np.einsum("ni,ni->n", np.cross(upper, fore), second[:, :3, 2])
    return np.arctan2(turn, np.einsum("ni,ni->n", upper, fore))


def spherical_answers(robot, pose):
    """All eight answers of an arm with a spherical wrist, in (-pi, pi], NaN where there is none."""
    n = len(pose)
    wrist = pose[:, :3, 3] - robot.joints[5].d_mm * pose[:, :3, 2]
    found = []
    for back, elbow in itertools.product((0, 1), (1, -1)):
        arm = _arm(robot, wrist, back, elbow)
        for flip in (1, -1):
            found.append(_with_wrist(robot, pose, arm, flip))
    return np.stack(found, axis=1).reshape(n, 8, 6)


def _wrap(angle):
    return np.pi - np.mod(np.pi - angle, FULL)


def _arm(robot, wrist, back, elbow):
    n, zero = len(wrist), np.zeros((1, 6))
    joints = np.zeros((n, 6))
    ahead = transform(robot, zero, 0, 1)[0, :3, 0]
    joints[:, 0] = robot.joints[0].sign * (
        np.arctan2(wrist[:, 1], wrist[:, 0]) - np.arctan2(ahead[1], ahead[0]) + back * np.pi
    )
    second, third = transform(robot, zero, 0, 2), transform(robot, zero, 0, 3)
    at_zero = transform(robot, zero, 0, 4)[:, :3, 3]
    upper = np.linalg.norm(third[0, :3, 3] - second[0, :3, 3])
    fore = np.linalg.norm(at_zero[0] - third[0, :3, 3])
    shoulder = transform(robot, joints, 0, 2)[:, :3, 3]
    reach = np.linalg.norm(wrist - shoulder, axis=1)
    cosine = (reach**2 - upper**2 - fore**2) / (2 * upper * fore)
    bend = elbow * np.arccos(np.where(np.abs(cosine) <= 1, cosine, np.nan))
    step = np.zeros((1, 6))
    step[0, 2] = 0.1
    bends = [_bend(second, third, transform(robot, q, 0, 4)[:, :3, 3])[0] for q in (zero, step)]
    per_angle = np.sign(_wrap(bends[1] - bends[0]))
    joints[:, 2] = per_angle * (bend - bends[0])
    about = transform(robot, joints, 0, 2)[:, :3, 2]
    there = transform(robot, joints, 0, 4)[:, :3, 3] - shoulder
    aim = wrist - shoulder
    turn = np.arctan2(np.einsum("ni,ni->n", np.cross(there, aim), about), np.einsum("ni,ni->n", there, aim))
    joints[:, 1] = robot.joints[1].sign * turn
    return joints


def _with_wrist(robot, pose, arm, flip):
    """Add the three angles of the wrist: RotZ RotY RotZ, after what stands between is taken out."""
    joints = arm.copy()
    rows = robot.joints
    before = transform(robot, arm, 0, 3)[:, :3, :3] @ _about_x(rows[3].alpha_rad)
    left = np.swapaxes(before, 1, 2) @ pose[:, :3, :3]
    way = np.sign(np.sin(rows[4].alpha_rad))  # RotX(90) turns z to -y
    alike = np.sign(np.sin(rows[5].alpha_rad)) == way
    if alike:
        left = left @ np.diag([1.0, -1.0, -1.0])
    beta = np.arccos(np.clip(left[:, 2, 2], -1, 1))
    first, second = (_wrap(rows[4].sign * (-way * b - rows[4].theta_offset_rad)) for b in (beta, -beta))
    wanted = (first >= 0) == (flip > 0)
    theta_5, angle_5 = np.where(wanted, beta, -beta), np.where(wanted, first, second)
    side = np.sign(theta_5) + (theta_5 == 0)
    theta_4 = np.arctan2(side * left[:, 1, 2], side * left[:, 0, 2])
    theta_6 = np.arctan2(side * left[:, 2, 1], -side * left[:, 2, 0])
    theta_6 = -theta_6 if alike else theta_6
    joints[:, 3] = rows[3].sign * (theta_4 - rows[3].theta_offset_rad)
    joints[:, 4] = angle_5
    joints[:, 5] = rows[5].sign * (theta_6 - rows[5].theta_offset_rad)
    return _wrap(joints)


def searched_answers(robot, pose, near, starts=64):
    """Answers of an arm of any kind, by damped Newton steps from many places, shape (n, starts + 1, 6)."""
    rng = np.random.default_rng(11)
    spread = rng.uniform(-np.pi, np.pi, (starts, 6))
    joints = np.concatenate([near[:, None], np.tile(spread, (len(pose), 1, 1))], axis=1).reshape(-1, 6)
    goal = np.repeat(pose, starts + 1, axis=0)
    for _ in range(40):
        error, jacobian = _error_and_jacobian(robot, joints, goal)
        damping = 1e-2 * np.minimum(1.0, np.linalg.norm(error, axis=1))[:, None, None] ** 2 + 1e-12
        transposed = np.swapaxes(jacobian, 1, 2)
        step = np.linalg.solve(transposed @ jacobian + damping * np.eye(6), transposed @ error[..., None])
        joints = joints + np.clip(step[..., 0], -0.5, 0.5)
    error, _ = _error_and_jacobian(robot, joints, goal)
    joints[np.linalg.norm(error, axis=1) > 1e-9] = np.nan
    return joints.reshape(len(pose), starts + 1, 6)


def _error_and_jacobian(robot, joints, goal):
    """What is left to go, in m and rad, and how it changes with the joints."""
    frames = np.stack([transform(robot, joints, 0, k) for k in range(1, 7)], axis=1)
    end = frames[:, 5]
    axes = frames[:, :, :3, 2] * np.array([row.sign for row in robot.joints])[None, :, None]
    shift = np.cross(axes, end[:, None, :3, 3] - frames[:, :, :3, 3]) / 1000.0
    turn = 0.5 * sum(np.cross(end[:, :3, k], goal[:, :3, k]) for k in range(3))
    error = np.concatenate([(goal[:, :3, 3] - end[:, :3, 3]) / 1000.0, turn], axis=1)
    return error, np.swapaxes(np.concatenate([shift, axes], axis=2), 1, 2)


def _about_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def turned_to(joints, near):
    """Answers with whole turns that bring them nearest to others."""
    return joints - FULL * np.round((joints - near) / FULL)
