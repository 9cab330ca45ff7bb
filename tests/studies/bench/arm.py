"""The arm that all are timed on, as plain arrays: what a peer is handed, and a numpy sketch of its own.

An IRB 120 after Craig's convention with one tool nest, every link off by some tenths of a millimetre and of a
degree, measured with noise. The sketch is what a careful engineer writes in an afternoon: forward kinematics,
derivatives as screws, Gauss-Newton on the normal equations; no priors, weights, springs or checks.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

ALPHA, A, BETA, THETA, D = range(5)
NOMINAL = np.array([
    [0.0, 0.0, 0.0, 0.0, 290.0],
    [-np.pi / 2, 0.0, 0.0, -np.pi / 2, 0.0],
    [0.0, 270.0, 0.0, 0.0, 0.0],
    [-np.pi / 2, 70.0, 0.0, 0.0, 302.0],
    [np.pi / 2, 0.0, 0.0, 0.0, 0.0],
    [-np.pi / 2, 0.0, 0.0, np.pi, 72.0],
])
TOOL = np.array([40.0, -25.0, 120.0])
_RANGE = np.deg2rad([165.0, 100.0, 85.0, 155.0, 115.0, 175.0])
_NOISE_MM = 0.02
# Rows of joints 2..6 but d_3, which acts as d_2 does, beta_3, and no zero and length of joint 6: the tool's
FREE = np.ones((6, 5), dtype=bool)
FREE[0] = False
FREE[:, BETA] = False
FREE[2, BETA], FREE[2, D], FREE[5, THETA], FREE[5, D] = True, False, False, False


class Readings(NamedTuple):
    """Joint angles (n, 6) [rad] and the measured places of the nest (n, 3) [mm]."""

    joints: np.ndarray
    measured: np.ndarray


def readings(n: int, seed: int = 0) -> Readings:
    """Return n readings of an arm with errors."""
    rng = np.random.default_rng(seed)
    width = np.where(np.isin(np.arange(5), (A, D)), 0.2, 1.7e-3)
    table = NOMINAL + FREE * width * rng.standard_normal(NOMINAL.shape)
    joints = rng.uniform(-_RANGE, _RANGE, (n, 6))
    place = predicted(np.zeros(6), table, TOOL, joints)[0]
    return Readings(joints, place + _NOISE_MM * rng.standard_normal((n, 3)))


def predicted(
    base: np.ndarray, table: np.ndarray, tool: np.ndarray, joints: np.ndarray
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]], np.ndarray]:
    """Places of the nest (n, 3), the axis and origin of each screw of the table in its order, and the end."""
    rotation = np.broadcast_to(
        _about(0, base[3]) @ _about(1, base[4]) @ _about(2, base[5]), (len(joints), 3, 3)
    )
    origin = np.broadcast_to(base[:3], (len(joints), 3))
    screws = []
    for row, angle in zip(table, joints.T, strict=True):
        screws += [(rotation[:, :, 0], origin)] * 2
        origin = origin + row[A] * rotation[:, :, 0]
        rotation = rotation @ _about(0, row[ALPHA])
        screws.append((rotation[:, :, 1], origin))
        rotation = rotation @ _about(1, row[BETA])
        c, s = np.cos(angle + row[THETA])[:, None], np.sin(angle + row[THETA])[:, None]
        x, y, z = np.moveaxis(rotation, 2, 0)
        rotation = np.stack([c * x + s * y, c * y - s * x, z], axis=2)
        origin = origin + row[D] * z
        screws += [(z, origin)] * 2
    return origin + rotation @ tool, screws, rotation


def identified(seen: Readings) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Newton on base, table and tool; returns their changes (P,) and the covariance."""
    base, table, tool = np.zeros(6), NOMINAL.copy(), TOOL.copy()
    for _ in range(20):
        place, screws, end = predicted(base, table, tool, seen.joints)
        jacobian = _jacobian(base, place, screws, end)
        scale = np.linalg.norm(jacobian, axis=1)
        unit = jacobian / scale[:, None]
        covariance = np.linalg.inv(unit @ unit.T)
        step = covariance @ (unit @ (seen.measured - place).ravel()) / scale
        base, tool = base + step[:6], tool + step[-3:]
        table[FREE] += step[6:-3]
        if np.abs(step * scale).max() < 1e-7 * np.sqrt(len(place)):
            break
    values = np.concatenate([base, (table - NOMINAL)[FREE], tool - TOOL])
    return values, _NOISE_MM**2 * covariance / np.outer(scale, scale)


def by_differences(seen: Readings) -> np.ndarray:
    """Return the same changes by scipy, which differentiates by differences of two predictions."""

    def misses(values: np.ndarray) -> np.ndarray:
        table = NOMINAL.copy()
        table[FREE] += values[6:-3]
        return (predicted(values[:6], table, TOOL + values[-3:], seen.joints)[0] - seen.measured).ravel()

    return least_squares(misses, np.zeros(6 + FREE.sum() + 3), jac="2-point", x_scale="jac").x


def _jacobian(base: np.ndarray, place: np.ndarray, screws: list, end: np.ndarray) -> np.ndarray:
    turns = (_about(0, base[3]), _about(0, base[3]) @ _about(1, base[4]))
    axes = (np.eye(3)[0], turns[0][:, 1], turns[1][:, 2])
    columns = [np.broadcast_to(axis, place.shape) for axis in np.eye(3)]
    columns += [np.cross(axis, place - base[:3]) for axis in axes]
    for (quantity, (axis, origin)), free in zip(enumerate(screws), np.ravel(FREE), strict=True):
        if free:
            columns.append(axis if quantity % 5 in (A, D) else np.cross(axis, place - origin))
    columns += list(np.moveaxis(end, 2, 0))
    return np.stack(columns).reshape(len(columns), -1)


def chosen(rows: np.ndarray, n: int, rng: np.random.Generator) -> list[int]:
    """Choose n candidates (N, 3, P): the best one comes, the most dispensable goes, while that helps."""
    members = rng.choice(len(rows), n, replace=False).tolist()
    before = -np.inf
    while (now := _information(rows[members])) > before + 1e-9:
        before, kept = now, list(members)
        members.append(int(np.argmax(_gains(rows, rows[members], 1.0))))
        losses = _gains(rows[members], rows[members], -1.0)
        del members[int(np.argmax(losses))]
    return kept


def _gains(candidates: np.ndarray, members: np.ndarray, sign: float) -> np.ndarray:
    flat = members.reshape(-1, members.shape[2])
    inverse = np.linalg.inv(flat.T @ flat)
    blocks = np.einsum("nip,nkp->nik", candidates @ inverse, candidates)
    return np.linalg.det(np.eye(3) + sign * blocks)


def _information(members: np.ndarray) -> float:
    flat = members.reshape(-1, members.shape[2])
    return float(np.linalg.slogdet(flat.T @ flat)[1])


def _about(axis: int, angle: float) -> np.ndarray:
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[second, first], turn[first, second] = np.sin(angle), -np.sin(angle)
    return turn


def craig_table() -> np.ndarray:
    """Nominal alpha, a, theta, d of each joint, shape (6, 4): what a peer takes."""
    return NOMINAL[:, [ALPHA, A, THETA, D]]


def craig_free() -> np.ndarray:
    """Which of these are found, shape (6, 4): all but the tilt, which the table of a peer does not have."""
    return FREE[:, [ALPHA, A, THETA, D]]


def candidate_rows(n: int) -> np.ndarray:
    """Derivatives of n candidates, columns scaled to unit length, shape (n, 3, P)."""
    joints = readings(n, seed=31).joints
    jacobian = _jacobian(np.zeros(6), *predicted(np.zeros(6), NOMINAL, TOOL, joints))
    unit = jacobian / np.linalg.norm(jacobian, axis=1, keepdims=True)
    return np.ascontiguousarray(unit.reshape(len(unit), n, 3).transpose(1, 2, 0))
