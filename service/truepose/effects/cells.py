"""Where each cause acts, what it depends on, with which shape: the one table that says so.

What has no trade name says it itself: its subject is its cell.
"""

from typing import NamedTuple, get_args

from truepose.domain.results.causes import Cause, Shape
from truepose.effects.causes import Candidate, CellRow, Drawn
from truepose.effects.installed import INSTALLED
from truepose.effects.unnamed.cause import NAME as UNNAMED


class Cell(NamedTuple):
    """A place, a variable, a shape."""

    where: str
    over: str
    shape: Shape


_OF_SUBJECT = "{subject}"
_CELLS = {
    **{name: brought.cell for name, brought in INSTALLED.causes.items()},
    "axis_parallelism": CellRow(_OF_SUBJECT, "constant", "group", "angle between the two axes"),
    "joint_gain": CellRow(
        _OF_SUBJECT,
        "angle of {subject}",
        "line",
        "share by which the joint turns further than it should",
        drawn="joint",
    ),
    "joint_harmonics": CellRow(
        _OF_SUBJECT,
        "angle of {subject}",
        "wave",
        "amplitude of the wave: half of peak to peak",
        function="curve",
        drawn="joint",
    ),
    "joint_coupling": CellRow(
        _OF_SUBJECT,
        "angle of joint {variant:g}",
        "line",
        "turn of this joint per turn of the other",
        drawn="joint",
    ),
    "backlash": CellRow(
        _OF_SUBJECT,
        "direction",
        "sign",
        "full gap between the two directions of approach",
        plural="joints",
        drawn="joint",
    ),
    "compliance": CellRow(
        _OF_SUBJECT,
        "torque of {subject}",
        "line",
        "turn of the joint per torque about its axis",
        drawn="joint",
    ),
    "compliance_nonlinear": CellRow(
        _OF_SUBJECT,
        "torque of {subject}",
        "curve",
        "additional compliance near zero torque, relative",
        plural="joints",
        drawn="joint",
    ),
    "link_bending": CellRow(
        _OF_SUBJECT, "load", "line", "displacement at the tool", plural="links", at="link"
    ),
    "payload": CellRow("tool", "load", "line", "mass by which the tool differs"),
    "link_mass": CellRow(
        _OF_SUBJECT, "load", "line", "mass by which the link differs", plural="links", at="link"
    ),
    "base_compliance": CellRow("base", "load", "line", "tilt of the base per moment"),
    "thermal_growth": CellRow(
        "links", "temperature", "line", "relative growth of lengths per kelvin", drawn="shift"
    ),
    "base_drift": CellRow(
        "base", "time", "drift", "speed of the translation", searched="settling", drawn="shift"
    ),
    "base_shift": CellRow("base", "time", "jump", "length of the translation", drawn="shift"),
    "instrument_drift": CellRow(
        "tracker", "time", "drift", "speed of the translation", searched="settling", drawn="shift"
    ),
    "instrument_scale": CellRow(
        _OF_SUBJECT, "range", "line", "share by which lengths are off", at="instrument"
    ),
    "nest_offset": CellRow(
        _OF_SUBJECT, "constant", "group", "distance from the certified place", at="nest", drawn="level"
    ),
    "tool_reseating": CellRow(
        "tool", "mounting", "group", "standard deviation from one mounting to the next", drawn="level"
    ),
    "ballbar_zero": CellRow("ballbar", "constant", "group", "constant error of a length"),
    "fixture_shift": CellRow(_OF_SUBJECT, "time", "jump", "length of the translation", at="placement"),
    "label_swap": CellRow("readings", "constant", "group", "share of the readings"),
    "outliers": CellRow("readings", "constant", "group", "share of the readings"),
}


# What leaves similar residuals: words of the places and variables of cells.
_KIN = (
    frozenset({"torque", "load"}),
    frozenset({"time", "temperature", "mounting", "ballbar", "placement"}),  # these run together
    frozenset({"nest", "mounting", "readings", "placement"}),  # where nests are
    frozenset({"range", "temperature", "ballbar"}),  # how long lengths are
)
_UNHEARD = CellRow(_OF_SUBJECT, "constant", "group")  # of what another version named
_APART = frozenset({"constant", "direction"})  # that two cells share such a variable says little
_ALL_JOINTS = frozenset({"joint", "joints"})
_SHAPES: dict[str, Shape] = {shape: shape for shape in get_args(Shape)}


def cell_of(candidate: Candidate) -> Cell:
    """Return where a candidate acts, over what, with which shape."""
    if candidate.effect == UNNAMED:
        return named_cell(candidate.effect, candidate.subject)
    row = _CELLS[candidate.effect]
    cell = _formatted(row, candidate.subject, candidate.variant)
    if candidate.function:
        return cell._replace(shape=row.function or row.shape)
    return cell._replace(shape=row.searched or row.shape) if candidate.variant != 0.0 else cell


def named_cell(effect: str, subject: str) -> Cell:
    """Return the cell of a cause by its name, before anything is searched; without a subject, that of any."""
    if effect != UNNAMED:
        return _formatted(_CELLS.get(effect, _UNHEARD), subject, 0.0)
    where, over, shape = subject.split(", ")
    return Cell(where, over, _SHAPES[shape])


def place_of(cause: Cause) -> tuple[str, str] | None:
    """Return where a cause acts and over what; None where its name alone does not say it."""
    row = _CELLS.get(cause.effect)
    if cause.effect != UNNAMED and (row is None or "{variant" in row.over):
        return None
    cell = named_cell(cause.effect, cause.subject)
    return cell.where, cell.over


def _formatted(row: CellRow, subject: str, variant: float) -> Cell:
    told = {"subject": subject or row.at, "variant": variant}
    return Cell(row.where.format(**told), row.over.format(**told), row.shape)


def plural_of(effect: str) -> str:
    """Return the subject of several that share a cause; "" where each stands alone."""
    return "" if effect == UNNAMED else _CELLS[effect].plural


def amplitude_of(effect: str) -> str:
    """Return what the amplitude of a cause is."""
    departure = _UNHEARD._replace(amplitude="largest departure, as its sentence says")
    return (departure if effect == UNNAMED else _CELLS.get(effect, _UNHEARD)).amplitude


def drawn_as(effect: str) -> Drawn:
    """Return which curve shows a cause over the readings."""
    return "agreement" if effect == UNNAMED else _CELLS.get(effect, _UNHEARD).drawn


def words_of(cell: Cell) -> frozenset[str]:
    """Return the words of a cell without its numbers: place, variable, both together, shape."""
    where, over = _kind(cell.where), _kind(cell.over)
    return frozenset({where, over, f"{where} {over}", cell.shape})


def of_instrument(cell: Cell) -> bool:
    """Whether a cell is one of the instrument instead of the robot."""
    return bool({"tracker", "instrument"} & words_of(cell))


def of_legs(cell: Cell) -> bool:
    """Whether a cell is one of a ballbar or of its base: campaigns of positions have none."""
    return bool({"ballbar", "placement"} & words_of(cell))


def alike(one: Cell, other: Cell) -> bool:
    """Whether two cells leave similar residuals: the same place, the same variable, or kin."""
    if one.over == other.over and one.over not in _APART:
        return True
    if {_kind(one.where), _kind(other.where)} <= _ALL_JOINTS:
        return one.where == other.where or bool(_ALL_JOINTS & {one.where, other.where})
    words = [words_of(cell) for cell in (one, other)]
    return one.where == other.where or any(kin & words[0] and kin & words[1] for kin in _KIN)


def _kind(words: str) -> str:
    """Return a place or a variable without what it is of: `angle` of `angle of joint 3`."""
    return words if words == "last move" else words.partition(" ")[0]
