"""Where each cause acts, what it depends on, with which shape: the one table that says so.

What has no trade name says it itself: its subject is its cell.
"""

from typing import NamedTuple, get_args

from service.domain.diagnosis import Shape
from service.effects.causes import Candidate
from service.effects.unnamed.cause import NAME as UNNAMED


class Cell(NamedTuple):
    """A place, a variable, a shape."""

    where: str
    over: str
    shape: Shape


class _Row(NamedTuple):
    """`{subject}` and `{variant}` are those of the candidate."""

    where: str
    over: str
    shape: Shape
    searched: Shape | None = None  # of candidates that were searched over
    function: Shape | None = None  # of random functions


_OF_SUBJECT = "{subject}"
_CELLS = {
    "axis_parallelism": _Row(_OF_SUBJECT, "constant", "group"),
    "joint_gain": _Row(_OF_SUBJECT, "angle of {subject}", "line"),
    "joint_harmonics": _Row(_OF_SUBJECT, "angle of {subject}", "wave", function="curve"),
    "joint_coupling": _Row(_OF_SUBJECT, "angle of joint {variant:g}", "line"),
    "backlash": _Row(_OF_SUBJECT, "direction", "sign"),
    "compliance": _Row(_OF_SUBJECT, "torque of {subject}", "line"),
    "compliance_nonlinear": _Row(_OF_SUBJECT, "torque of {subject}", "curve"),
    "link_bending": _Row(_OF_SUBJECT, "load", "line"),
    "payload": _Row("tool", "load", "line"),
    "link_mass": _Row(_OF_SUBJECT, "load", "line"),
    "base_compliance": _Row("base", "load", "line"),
    "thermal_growth": _Row("links", "temperature", "line"),
    "base_drift": _Row("base", "time", "drift", searched="settling"),
    "base_shift": _Row("base", "time", "jump"),
    "instrument_drift": _Row("tracker", "time", "drift", searched="settling"),
    "instrument_scale": _Row(_OF_SUBJECT, "range", "line"),
    "nest_offset": _Row(_OF_SUBJECT, "constant", "group"),
    "tool_reseating": _Row("tool", "mounting", "group"),
    "ballbar_zero": _Row("ballbar", "constant", "group"),
    "fixture_shift": _Row(_OF_SUBJECT, "time", "jump"),
    "label_swap": _Row("readings", "constant", "group"),
    "outliers": _Row("readings", "constant", "group"),
}


_SHAPES: dict[str, Shape] = {shape: shape for shape in get_args(Shape)}


def cell_of(candidate: Candidate) -> Cell:
    """Return where a candidate acts, over what, with which shape."""
    if candidate.effect == UNNAMED:
        where, over, shape = candidate.subject.split(", ")
        return Cell(where, over, _SHAPES[shape])
    row, told = _CELLS[candidate.effect], {"subject": candidate.subject, "variant": candidate.variant}
    return Cell(row.where.format(**told), row.over.format(**told), _shape_of(row, candidate))


def _shape_of(row: _Row, candidate: Candidate) -> Shape:
    if candidate.function:
        return row.function or row.shape
    return row.searched or row.shape if candidate.variant != 0.0 else row.shape
