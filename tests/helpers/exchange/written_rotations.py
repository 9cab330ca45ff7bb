"""Rotations as files write them, each by plain formulas of its own."""

import numpy as np


def vector(matrix):
    """Axis times angle."""
    w, *v = quaternion(matrix)
    size = np.linalg.norm(v)
    return np.array(v) * (2 * np.arctan2(size, w) / size if size else 2.0)


def from_vector(v):
    angle = np.linalg.norm(v, axis=1, keepdims=True)
    half = np.where(angle > 0, np.sin(angle / 2) / np.where(angle > 0, angle, 1.0), 0.5)
    return from_quaternion(np.concatenate([np.cos(angle / 2), half * v], axis=1))


def quaternion(m):
    """Shepperd's way: by the largest of the four, its sign positive."""
    diagonal = np.array([np.trace(m), *np.diag(m)])
    k = int(diagonal.argmax())
    if k == 0:
        q = np.array([1 + np.trace(m), m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i, j, h = k - 1, k % 3, (k + 1) % 3
        q = np.zeros(4)
        q[0], q[k] = m[h, j] - m[j, h], 1 + m[i, i] - m[j, j] - m[h, h]
        q[j + 1], q[h + 1] = m[j, i] + m[i, j], m[h, i] + m[i, h]
    q = q / np.linalg.norm(q)
    return q if q[0] >= 0 else -q


def from_quaternion(q):
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def zyx(m):
    """Degrees about Z, the new Y, the newest X."""
    return np.degrees([
        np.arctan2(m[1, 0], m[0, 0]),
        np.arctan2(-m[2, 0], np.hypot(m[0, 0], m[1, 0])),
        np.arctan2(m[2, 1], m[2, 2]),
    ])


def from_zyx(degrees):
    a, b, c = np.radians(degrees).T
    ca, sa, cb, sb, cc, sc = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    rows = [
        [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
        [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
        [-sb, cb * sc, cb * cc],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
