"""The rigid motion that brings points onto others best (W. Kabsch, Acta Cryst. A 32, 1976, 922-923)."""

import numpy as np

from truepose_simulators.physics.rigid import FloatArray, motion


def register(from_mm: FloatArray, onto_mm: FloatArray) -> FloatArray:
    """Return the motion, shape (4, 4), of points (m, 3) onto others in the least squares sense."""
    centre_from, centre_onto = from_mm.mean(axis=0), onto_mm.mean(axis=0)
    u, _, vt = np.linalg.svd((onto_mm - centre_onto).T @ (from_mm - centre_from))
    handed = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(u @ vt)))])
    turned = u @ handed @ vt
    return motion(centre_onto - turned @ centre_from, turned)
