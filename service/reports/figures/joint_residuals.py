"""Residual against each joint angle: what a missing effect of that joint would bend."""

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from service.domain.arrays import FloatArray
from service.reports.figures.canvas import AFTER, MUTED, X, Y, Z, new_figure, page_style, to_svg
from service.reports.judged import Judged

_COLUMNS = 3
_MOST_POINTS = 400  # dots of one colour in one panel; more make no one wiser and the file heavy
_BANDWIDTH = 0.08  # of the joint's range: follows one wave per range, not single readings
_FEWEST_BESIDE = 5.0  # readings that must carry the guide where it is drawn


def joint_residuals(judged: Judged) -> Markup:
    """Return one panel per joint with the identified model's residuals, per component, and an eye-guide."""
    angles_deg = np.degrees(judged.stops.joints_rad)
    rows = -(-angles_deg.shape[1] // _COLUMNS)
    with page_style():
        figure = new_figure(8.0, 2.1 * rows + 0.4)
        panels = figure.subplots(rows, _COLUMNS, sharey=True, squeeze=False).ravel()
        for joint, axes in enumerate(panels):
            if joint < angles_deg.shape[1]:
                _panel(axes, angles_deg[:, joint], judged)
                axes.set_title(f"joint {joint + 1} [deg]")
            else:
                axes.set_visible(False)
        _limit(panels[0], judged.identified_mm)
        figure.supylabel("residual [mm]", fontsize=9)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=4)
        return to_svg(figure, "joints", "Residuals of the identified model against each joint angle")


def _panel(axes: Axes, angle_deg: FloatArray, judged: Judged) -> None:
    residual = judged.identified_mm
    names = zip((X, Y, Z), "xyz", strict=True) if residual.shape[1] == 3 else [(AFTER, "length")]
    shown = slice(None, None, -(-len(residual) // _MOST_POINTS))
    noise = float(np.sqrt(np.trace(judged.covariance_mm2, axis1=1, axis2=2).mean() / residual.shape[1]))
    axes.axhspan(
        -2.0 * noise, 2.0 * noise, color=MUTED, alpha=0.15, linewidth=0.0, label="± 2 u of the instrument"
    )
    for component, (colour, name) in enumerate(names):
        axes.plot(angle_deg[shown], residual[shown, component], ".", color=colour, markersize=2.0, alpha=0.45)
        grid, guide = eye_guide(angle_deg, residual[:, component])
        axes.plot(grid, guide, color=colour, linewidth=1.6, label=name)


def _limit(axes: Axes, residual: FloatArray) -> None:
    """Show nearly all residuals: a few gross ones would flatten everything else."""
    typical = float(np.quantile(np.abs(residual), 0.99))
    if typical > 0.0:
        axes.set_ylim(-1.4 * typical, 1.4 * typical)


def eye_guide(angle_deg: FloatArray, residual_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Smooth residuals over an angle (Nadaraya-Watson with a normal kernel).

    Parameters
    ----------
    angle_deg : ndarray, shape (n,)
    residual_mm : ndarray, shape (n,)
        Cut at four times their median size first, so that gross readings do not draw the guide.

    Returns
    -------
    grid_deg, guide_mm : ndarray, shape (m,)
        Where enough readings stand beside; NaN elsewhere. Empty where the joint did not move.
    """
    span = float(np.ptp(angle_deg))
    if span < 1e-6:
        return np.zeros(0), np.zeros(0)
    cut = 4.0 * float(np.median(np.abs(residual_mm)))
    grid = np.linspace(angle_deg.min(), angle_deg.max(), 80)
    weights = np.exp(-0.5 * ((grid[:, None] - angle_deg) / (_BANDWIDTH * span)) ** 2)
    beside = weights.sum(axis=1)
    guide = weights @ np.clip(residual_mm, -cut, cut) / np.maximum(beside, 1e-12)
    return grid, np.where(beside >= _FEWEST_BESIDE, guide, np.nan)
