"""What a cell without a trade name is: a place, what it depends on there, a shape, and how to say it.

A kind is a row of the table of such cells. Each of its cells acts at one place, given by one or two numbers
(of joints, from 1; of links, from 0, which is the base), in one variant (a moment, an order), with one
parameter for each part of the kind. Names of parameters are taken apart at their underscores: no kind, part
or variant has one, and no place or variable has a comma with a blank, at which subjects are taken apart.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Shape
from truepose.domain.identification import Unit
from truepose.effects.causes import Limits, Scene
from truepose.effects.ports import NOTHING, Need, Port, Rows
from truepose.messages.message import Text

_PREFIX = "cell"
ALONE = (0,)  # the place of what a cell has one of: the tool, the instrument
STEADY = (("line", 0.0),)  # the variant of shapes that have one only

Place = tuple[int, ...]
Moves = list[tuple[Port, float | FloatArray]]  # ports, each with what it moves by per unit of the parameter
Variants = Iterable[tuple[str, float]]  # as names carry them, and as a number


class Key(NamedTuple):
    """A parameter of a cell: its name is `cell_<kind>_<place>_<variant>_<part>`.

    Attributes
    ----------
    kind : str
    place : tuple of int
    variant : str
        As names carry it.
    part : str
    """

    kind: str
    place: Place
    variant: str
    part: str

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return "_".join((_PREFIX, self.kind, "-".join(map(str, self.place)), self.variant, self.part))


def key_of(name: str) -> Key:
    """Return what a parameter is of, from its name alone; names that were stored lead back to their cells."""
    _, kind, place, variant, part = name.split("_")
    return Key(kind, tuple(map(int, place.split("-"))), variant, part)


class Part(NamedTuple):
    """One parameter of every cell of a kind.

    Attributes
    ----------
    name : str
    unit : Unit
    width : float
        Standard deviation of what is believed before any reading; the mean is 0.
    """

    name: str
    unit: Unit
    width: float  # standard deviation of what is believed before any reading


class Size(NamedTuple):
    """How large a cell is, in the units of documents (angles in deg).

    Attributes
    ----------
    amplitude : float
        Of the parts in the unit of the first one.
    beside : float
        Of the others.
    """

    amplitude: float  # of the parts in the unit of the first one
    beside: float = 0.0  # of the others


def exactly(_variant: float, _scene: Scene) -> float:
    """Return the uncertainty of what is a whole number."""
    return 0.0


@dataclass(frozen=True, slots=True)
class Kind:
    """One row of the table.

    Attributes
    ----------
    name : str
    shape : Shape
    parts : tuple of Part
        Those in the unit of the first are the amplitude.
    where, over : callable
        Words of the place and of the variable, from the place.
    places : callable
        Those that the data of a scene can show.
    variants : callable
        Those that are tried in a scene: as names carry them, and as numbers.
    moves : callable
        Ports that a parameter moves, each with its weight, a number or (n,).
    sentence : callable
        What a finding says, from its largest variant and its size.
    variant_is : tuple of str, or None
        Name and unit of the variant among the details; its labels are numbers then.
    variant_known_to : callable
        Standard uncertainty of the variant.
    limits : Limits or None
        Of the amplitude, by physics.
    needs : frozenset of str
        What a row must tell so that a cell can be predicted there.
    """

    name: str
    shape: Shape
    parts: tuple[Part, ...]
    where: Callable[[Place], str]
    over: Callable[[Place], str]
    # Asked with the data and not with the robot alone: a joint that did not turn has no wave that could be
    # found.
    places: Callable[[Scene], Iterable[Place]]  # those that the data can show
    variants: Callable[[Scene], Variants]
    moves: Callable[[Key, Rows], Moves]
    sentence: Callable[[Key, Size, Scene], Text]
    variant_is: tuple[str, str] | None = None  # name and unit of the variant among the details
    variant_known_to: Callable[[float, Scene], float] = exactly  # standard uncertainty of the variant
    limits: Limits | None = None  # of the amplitude, by physics
    # A drift of a joint needs times, a wave nothing: `Unnamed` as a whole has no answer that fits all of its
    # cells.
    needs: frozenset[Need] = NOTHING  # what a row must tell so that a cell can be predicted there

    def subject(self, place: Place) -> str:
        """Return what tells a cell from all others, e.g. `joint 3, time, jump`."""
        return f"{self.where(place)}, {self.over(place)}, {self.shape}"


def once(of: str) -> Callable[[Place], str]:
    """Return the words of a place, or of a variable, that is the same for all cells of a kind."""
    return lambda _place: of
