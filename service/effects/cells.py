"""Where each cause acts, what it depends on, with which shape: the one table that says so.

What has no trade name says it itself: its subject is its cell.
"""

from typing import NamedTuple, get_args

from service.domain.diagnosis import Cause, Shape
from service.effects.causes import Candidate, CellRow
from service.effects.installed import INSTALLED
from service.effects.unnamed.cause import NAME as UNNAMED


class Cell(NamedTuple):
    """A place, a variable, a shape."""

    where: str
    over: str
    shape: Shape


_OF_SUBJECT = "{subject}"
_CELLS = {
    **{name: brought.cell for name, brought in INSTALLED.causes.items()},
    "axis_parallelism": CellRow(_OF_SUBJECT, "constant", "group"),
    "joint_gain": CellRow(_OF_SUBJECT, "angle of {subject}", "line"),
    "joint_harmonics": CellRow(_OF_SUBJECT, "angle of {subject}", "wave", function="curve"),
    "joint_coupling": CellRow(_OF_SUBJECT, "angle of joint {variant:g}", "line"),
    "backlash": CellRow(_OF_SUBJECT, "direction", "sign"),
    "compliance": CellRow(_OF_SUBJECT, "torque of {subject}", "line"),
    "compliance_nonlinear": CellRow(_OF_SUBJECT, "torque of {subject}", "curve"),
    "link_bending": CellRow(_OF_SUBJECT, "load", "line"),
    "payload": CellRow("tool", "load", "line"),
    "link_mass": CellRow(_OF_SUBJECT, "load", "line"),
    "base_compliance": CellRow("base", "load", "line"),
    "thermal_growth": CellRow("links", "temperature", "line"),
    "base_drift": CellRow("base", "time", "drift", searched="settling"),
    "base_shift": CellRow("base", "time", "jump"),
    "instrument_drift": CellRow("tracker", "time", "drift", searched="settling"),
    "instrument_scale": CellRow(_OF_SUBJECT, "range", "line"),
    "nest_offset": CellRow(_OF_SUBJECT, "constant", "group"),
    "tool_reseating": CellRow("tool", "mounting", "group"),
    "ballbar_zero": CellRow("ballbar", "constant", "group"),
    "fixture_shift": CellRow(_OF_SUBJECT, "time", "jump"),
    "label_swap": CellRow("readings", "constant", "group"),
    "outliers": CellRow("readings", "constant", "group"),
}


_SHAPES: dict[str, Shape] = {shape: shape for shape in get_args(Shape)}


def cell_of(candidate: Candidate) -> Cell:
    """Return where a candidate acts, over what, with which shape."""
    if candidate.effect == UNNAMED:
        where, over, shape = candidate.subject.split(", ")
        return Cell(where, over, _SHAPES[shape])
    row, told = _CELLS[candidate.effect], {"subject": candidate.subject, "variant": candidate.variant}
    return Cell(row.where.format(**told), row.over.format(**told), _shape_of(row, candidate))


def place_of(cause: Cause) -> tuple[str, str] | None:
    """Return where a cause acts and over what; None where its name alone does not say it."""
    row = _CELLS.get(cause.effect)
    if cause.effect != UNNAMED and (row is None or "{variant" in row.over):
        return None
    cell = cell_of(Candidate(cause.effect, cause.subject, ()))
    return cell.where, cell.over


def _shape_of(row: CellRow, candidate: Candidate) -> Shape:
    if candidate.function:
        return row.function or row.shape
    return row.searched or row.shape if candidate.variant != 0.0 else row.shape
