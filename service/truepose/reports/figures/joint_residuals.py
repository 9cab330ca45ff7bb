"""Residual against each joint angle, as that joint would see it.

In world axes a gear's wave is hidden: the arm's attitude turns it everywhere. Each panel therefore
splits the residual along the motion of its joint, along its axis and away from it.
"""

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import FloatArray
from truepose.identification.verdict.judge import Assessment
from truepose.kinematics.chain import theta_gradient
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.figures.svg_rendering import (
    AFTER,
    MUTED,
    X,
    Y,
    Z,
    mark_axis,
    new_figure,
    page_style,
    to_svg,
)

_COLUMNS = 3
_DIRECTIONS = ("joints.along_motion", "joints.along_axis", "joints.away")
_MOST_POINTS = 400  # dots of one colour in one panel; more make no one wiser and the file heavy
_LEGEND_SCALE = 4.0  # its dots must show their colour
_BANDWIDTH = 0.04  # of the joint's range: shows two waves per turn nearly undamped
_READINGS_ASKED = 5.0  # a wider guide where readings are few: 2.5 times as many then carry each of its points
_FEWEST_BESIDE = 5.0  # readings that must carry the guide where it is drawn


_SHORTEST_ARM_MM = 1e-3  # nearer to its axis, a joint moves the nest in no direction to speak of


@dataclass(frozen=True, slots=True)
class JointResiduals:
    """The picture, and what its caption must state."""

    picture: Markup
    guides: bool  # whether any panel has one
    band: bool  # of the instrument


def joint_residuals(judged: Assessment, words: Catalogue = IN_ENGLISH) -> JointResiduals:
    """Return one panel per joint with the identified model's residuals and an eye-guide."""
    seen = residuals_by_joint(judged)
    angles_deg = np.degrees(judged.stops.joints_rad)
    rows = -(-angles_deg.shape[1] // _COLUMNS)
    guides, noise_mm = False, _noise_mm(judged)
    with page_style():
        figure = new_figure(8.0, 2.1 * rows + 0.4)
        panels = figure.subplots(rows, _COLUMNS, sharey=True, squeeze=False).ravel()
        for joint, axes in enumerate(panels):
            if joint < angles_deg.shape[1]:
                _band(axes, noise_mm, words)
                guides |= _panel(axes, angles_deg[:, joint], seen[joint], words)
                mark_axis(axes.xaxis, words.units.conversion("deg"))
                axes.set_title(words.say("joints.panel", joint=f"joint {joint + 1}"))
            else:
                axes.set_visible(False)
        _limit(panels[0], judged.identified_mm)
        mark_axis(panels[0].yaxis, words.units.conversion("mm"))
        figure.supylabel(words.say("joints.residual"), fontsize=9)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=4, markerscale=_LEGEND_SCALE)
        picture = to_svg(figure, "joints", words.say("joints.picture"), words)
        return JointResiduals(picture, guides, noise_mm > 0.0)


def _noise_mm(judged: Assessment) -> float:
    components = judged.identified_mm.shape[1]
    return float(np.sqrt(np.trace(judged.block.covariance(), axis1=1, axis2=2).mean() / components))


def _band(axes: Axes, noise_mm: float, words: Catalogue) -> None:
    if noise_mm > 0.0:
        name = words.say("joints.band")
        axes.axhspan(-2.0 * noise_mm, 2.0 * noise_mm, color=MUTED, alpha=0.15, linewidth=0.0, label=name)


def _panel(axes: Axes, angle_deg: FloatArray, residual: FloatArray, words: Catalogue) -> bool:
    """Draw the residuals over one angle; return whether there is a guide to the eye."""
    guided = False
    names = zip((X, Y, Z), _DIRECTIONS, strict=True) if residual.shape[1] == 3 else [(AFTER, "joints.length")]
    shown = slice(None, None, -(-len(residual) // _MOST_POINTS))
    for component, (colour, name) in enumerate(names):
        grid, guide = eye_guide(angle_deg, residual[:, component])
        axes.plot(
            angle_deg[shown],
            residual[shown, component],
            ".",
            color=colour,
            markersize=2.0,
            alpha=0.45,
            label=words.say(name),
        )
        if np.isfinite(guide).any():
            guided = True
            axes.plot(grid, guide, color=colour, linewidth=1.6)
    return guided


def residuals_by_joint(judged: Assessment) -> FloatArray:
    """Return the residuals of the identified model in cylinder coordinates of each joint.

    Returns
    -------
    ndarray, shape (J, n, 3)
        Along the motion of the joint, along its axis, away from its axis [mm]; (J, n, 1) for lengths,
        which have no other direction than their own.
    """
    stops, residual = judged.stops, judged.identified_mm
    if judged.block.quantity == "length":
        return np.broadcast_to(residual, (stops.joints_rad.shape[1], *residual.shape))
    state = judged.identified.state
    motion = theta_gradient(state.chain, state.position_mm)
    arm = np.linalg.norm(motion, axis=2, keepdims=True)
    along = np.where(arm > _SHORTEST_ARM_MM, motion / np.maximum(arm, _SHORTEST_ARM_MM), 0.0)
    axis = state.chain.z
    away = np.cross(along, axis)
    return np.stack([np.einsum("jnk,nk->jn", d, residual) for d in (along, axis, away)], axis=2)


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
    width = span * max(_BANDWIDTH, _READINGS_ASKED / len(angle_deg))
    weights = np.exp(-0.5 * ((grid[:, None] - angle_deg) / width) ** 2)
    beside = weights.sum(axis=1)
    guide = weights @ np.clip(residual_mm, -cut, cut) / np.maximum(beside, 1e-12)
    return grid, np.where(beside >= _FEWEST_BESIDE, guide, np.nan)
