"""Figures of the pose device: how many assemblies, and how uncertain its points are (thesis, table 3.1)."""

from typing import Final

import numpy as np

from tests.studies.report_command import target_row
from truepose.domain.arrays import FloatArray
from truepose.exchange.cells.file import simulated_cell
from truepose.kinematics.pose_device import (
    DESIGNS,
    assemblies,
    base_triangle,
    distinct,
    measurable,
    points_covariance,
    solve,
)
from truepose.reports.table_report import Row, Section

_SIGMA_MM: Final = 0.00051  # a QC20-W, thesis section 3.5
_TWELVE_MM: Final = np.array([300.0] * 3 + [150.0] * 3 + [300.0] * 6)  # base sides, tool sides, legs
_PATTERN: Final = DESIGNS[0]  # the design of the table
# Norms in units of the ballbar's sigma, solutions 1 to 4. T1 and T2 as printed; T3 with what T1 and T2 have
# in common, which the printed 3.179, 3.054, 2.853, 3.180 leave out.
_TABLE: Final = {
    "T1": (2.309, 2.309, 2.309, 2.309),
    "T2": (2.646, 2.646, 2.480, 2.480),
    "T3": (3.36, 3.05, 2.89, 3.33),
}
_T1_AXES: Final = (1.5, 1.6, 0.7)
_PRINTED: Final = {"T1": 5e-4, "T2": 5e-4, "T3": 5e-3}  # half a unit of the last digit
_SIMULATED_WITHIN: Final = 0.03
_BLOCK: Final = 500  # draws between two reports of progress


def pose_device_section(draws: int, seed: int) -> Section:
    """Return the figures of the pose device; `draws` times all twelve lengths are drawn."""
    nominal = _solutions(_TWELVE_MM)
    covariance = points_covariance(_PATTERN, base_triangle(300.0, 300.0, 300.0), nominal, np.eye(12))
    by_propagation = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)).reshape(4, 3, 3)
    by_drawing = simulated_sigma(draws, np.random.default_rng(seed))
    rows = (
        *_counts(),
        _axes_row(by_propagation[0, 0]),
        *(_propagated_row(name, k, by_propagation[:, k]) for k, name in enumerate(_TABLE)),
        *(_simulated_row(name, k, by_drawing[:, k]) for k, name in enumerate(_TABLE)),
    )
    return Section("The pose device", rows, f"Uncertainties in sigma of the ballbar; {draws} draws.")


def simulated_sigma(draws: int, rng: np.random.Generator) -> FloatArray:
    """Return the standard deviations of nests when all twelve lengths scatter, shape (4, 3, 3) [sigma].

    Solutions, nests, axes of the base; base and tool triangle are measured with the same ballbar.
    """
    twelve = _TWELVE_MM + _SIGMA_MM * rng.standard_normal((draws, 12))
    placed = np.array([_solutions(one) for one in twelve])
    return np.asarray(placed.std(axis=0, ddof=1) / _SIGMA_MM)


def _solutions(twelve_mm: FloatArray) -> FloatArray:
    cups = base_triangle(*(float(side) for side in twelve_mm[:3]))
    return solve(_PATTERN, cups, twelve_mm[3:6], twelve_mm[6:])


def _counts() -> tuple[Row, ...]:
    nests = np.array([nest.centre_mm for nest in simulated_cell("lrmate-tilted", 0).nests], dtype=np.float64)
    cups = base_triangle(300.0, 300.0, 300.0)
    every = assemblies(cups, nests)
    possible = measurable(every, cups, nests)
    found = {"assemblies": (144, every), "measurable": (72, possible), "distinct": (54, distinct(possible))}
    return tuple(
        target_row(name, str(wanted), str(len(got)), len(got) == wanted)
        for name, (wanted, got) in found.items()
    )


def _axes_row(sigma: FloatArray) -> Row:
    good = bool(np.all(np.abs(sigma - _T1_AXES) < 0.06))  # printed with one decimal, 0.75 as 0.7
    return target_row("T1, per axis", _text(_T1_AXES, 1), _text(sigma, 2), good)


def _propagated_row(name: str, nest: int, sigma: FloatArray) -> Row:
    """Return the norms of nest `nest` of the pattern in the four solutions beside the table's."""
    norms = np.linalg.norm(sigma, axis=1)
    digits = 2 if name == "T3" else 3
    good = bool(np.all(np.abs(norms - _TABLE[name]) <= _PRINTED[name]))
    return target_row(
        f"{name}, propagated, solutions 1 to 4", _text(_TABLE[name], digits), _text(norms, digits + 1), good
    )


def _simulated_row(name: str, nest: int, sigma: FloatArray) -> Row:
    norms = np.linalg.norm(sigma, axis=1)
    off = float(np.max(np.abs(norms / _TABLE[name] - 1.0)))
    return target_row(
        f"{name}, drawn, farthest from the table",
        "<= 3 %",
        f"{100 * off:.2f} % ({_text(norms, 3)})",
        off <= _SIMULATED_WITHIN,
    )


def _text(values: FloatArray | tuple[float, ...], digits: int) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)
