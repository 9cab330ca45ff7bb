"""What a robot program says: its targets, the order in which they are visited, and what is left alone.

`formats.read_program` makes a Program of a file, `rewriting.rewritten` the file again with other numbers.
Inside are mm and rad; a quaternion is of norm 1, w first. Branch and external axes are kept as they stand.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

from truepose.domain.errors import ConfigurationError
from truepose.domain.results.corrections import LeftAlone
from truepose.domain.sentences import Sentence, Text

Triple: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]
Path: TypeAlias = Literal["joints", "line"]  # how a motion gets to its target


@dataclass(frozen=True, slots=True)
class Configuration:
    """Joint angles of the arm, without external axes."""

    joints_rad: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Pose:
    """A frame in another one."""

    position_mm: Triple
    quaternion: Quaternion

    @classmethod
    def written(cls, position: "Written", rotation: "Written") -> "Pose":
        """Return the pose that stands in the file as a position and a rotation."""
        x, y, z = position.read()
        a, b, c, d = rotation.read()
        return cls((x, y, z), (a, b, c, d))


Value: TypeAlias = Configuration | Pose
AT_THE_ORIGIN: Final = Pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True)
class Frame:
    """A tool in the flange, or a work object in the world; without a pose the file only names it."""

    name: str
    pose: Pose | None = None
    spoken: Sentence | None = None  # a name that the reader made, for people; None: it stands in the file

    @property
    def shown(self) -> Text:
        """How sentences name it."""
        return self.spoken or self.name


@dataclass(frozen=True, slots=True)
class Number:
    """A number as it stands in the text; `value` is in the unit of the file."""

    start: int  # first byte
    end: int  # behind the last byte
    value: float
    decimals: int  # places behind the decimal point
    base: Literal[2, 10, 16] = 10  # KRL also writes 'B010011' and 'H13'


@dataclass(frozen=True, slots=True)
class Form:
    """How three, four or more numbers of a file stand for a position, a rotation or joint angles."""

    inward: Callable[[Sequence[float]], tuple[float, ...]]  # from the numbers of the file
    outward: Callable[[Sequence[float], Sequence[float]], Sequence[float]]  # and back, near those that stood
    decimals: int  # that the format takes, and that a round trip needs


@dataclass(frozen=True, slots=True)
class Written:
    """Where a position, a rotation or joint angles stand in the file, and in which form."""

    numbers: tuple[Number, ...]
    form: Form

    @property
    def values(self) -> tuple[float, ...]:
        """The numbers in the unit of the file."""
        return tuple(number.value for number in self.numbers)

    def read(self) -> tuple[float, ...]:
        """Return what the numbers stand for."""
        return self.form.inward(self.values)


@dataclass(frozen=True, slots=True)
class ProgramTarget:
    """A target whose numbers stand in the file.

    Attributes
    ----------
    name : str
        As the program calls it, with the index of an array; one without a name is called by its line.
    line : int
        1-based.
    value : Configuration or Pose
        A pose is that of `tool` in `work_object`.
    branch : str
        What the file says of the branch, in its own words: the four numbers of ABB's confdata, KUKA's
        ``S 2, T 35``, FANUC's ``N U T, 0, 0, 0``.
    turns : tuple of Number
        What of it counts turns or quadrants and can follow joints: cf1, cf4 and cf6, or T.
    near_rad : tuple of float, optional
        The configuration that the file names beside a pose.
    external : tuple of float
        External axes in the units of the file. They never change.
    tool, work_object : Frame, optional
        None where the file does not say with which one the target is used.
    written : tuple of Written
        Where the numbers stand: of a configuration the joint angles, of a pose position and rotation.
    """

    name: str
    line: int
    value: Value
    written: tuple[Written, ...] = field(repr=False)
    branch: str = ""
    turns: tuple[Number, ...] = field(default=(), repr=False)
    near_rad: tuple[float, ...] | None = None
    external: tuple[float, ...] = ()
    tool: Frame | None = None
    work_object: Frame | None = None

    def known_rad(self, joints: int) -> tuple[float, ...] | None:
        """Return the configuration that the file gives; raises ConfigurationError for another arm's."""
        known = self.value.joints_rad if isinstance(self.value, Configuration) else self.near_rad
        if known is not None and len(known) != joints:
            raise ConfigurationError(
                f"{self.name} in line {self.line} has {len(known)} joints, the model has {joints}: the "
                "program is of another robot."
            )
        return known


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion to a target.

    `before` is the target at which the motion begins; None where straight-line code does not tell it:
    after a branch, a call, a motion that is left alone. `file` is that of the line, if it is another one.
    """

    line: int
    target: int  # index among the targets
    path: Path
    before: int | None = None
    file: str | None = None


@dataclass(frozen=True, slots=True)
class Program:
    """A robot program as it was read; `data` is the file, `again` reads the same file with other numbers."""

    name: str
    format: str
    data: bytes = field(repr=False)
    targets: tuple[ProgramTarget, ...]
    motions: tuple[Motion, ...]
    left_alone: tuple[LeftAlone, ...]
    again: Callable[[bytes], "Program"] | None = field(default=None, repr=False, compare=False)
