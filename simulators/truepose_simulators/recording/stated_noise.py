"""Noise as a campaign states it of each reading: a covariance, along and across the beam, or one number."""

import numpy as np

from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.replaying.measured_table import MeasuredTable

_COVARIANCE = (("cxx", "cxy", "cxz"), ("cxy", "cyy", "cyz"), ("cxz", "cyz", "czz"))  # mm2


def draw_noise(
    table: MeasuredTable, position_mm: FloatArray, instrument_mm: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Draw noise for readings at positions (n, 3) by an instrument at a place (3,), shape (n, 3) [mm]."""
    values, axes = np.linalg.eigh(stated_covariance(table, position_mm, instrument_mm))
    along_axes = np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(position_mm.shape)
    noise: FloatArray = np.einsum("nij,nj->ni", axes, along_axes)
    return noise


def stated_covariance(table: MeasuredTable, position_mm: FloatArray, instrument_mm: FloatArray) -> FloatArray:
    """Covariance of every reading, shape (n, 3, 3) [mm2]; the most detailed statement of a row counts."""
    covariance = _variance(table.known("u_mm"), np.eye(3))
    if "u_along_mm" in table and "u_across_mm" in table:
        along, across = table.numbers("u_along_mm"), table.numbers("u_across_mm")
        beam = position_mm - instrument_mm
        beam = beam / np.linalg.norm(beam, axis=1, keepdims=True)
        projector = beam[:, :, np.newaxis] * beam[:, np.newaxis, :]
        on_beam = _variance(along, projector) + _variance(across, np.eye(3) - projector)
        covariance = _where_stated(on_beam, covariance)
    if all(name in table for row in _COVARIANCE for name in row):
        full = np.array([[table.numbers(name) for name in row] for row in _COVARIANCE])
        covariance = _where_stated(np.moveaxis(full, 2, 0), covariance)
    return covariance


def _variance(u_mm: FloatArray, shape: FloatArray) -> FloatArray:
    variance: FloatArray = u_mm[:, np.newaxis, np.newaxis] ** 2 * shape
    return variance


def _where_stated(detailed: FloatArray, plain: FloatArray) -> FloatArray:
    stated = np.isfinite(detailed).all(axis=(1, 2), keepdims=True)
    return np.where(stated, detailed, plain)
