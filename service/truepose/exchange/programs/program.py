"""What a robot program says: its targets, the order in which they are visited, and what is left alone.

`formats.read_program` makes a Program of a file, `number_replacement.rewritten` the file again with other
numbers. Inside are mm and rad; a quaternion is of norm 1, w first. Branch and external axes are kept as they
stand.

A program is read as Latin-1, in which every byte is one character: places in the text are places in the
file, whatever its encoding. Names are shown as UTF-8 where they are that.
"""

import bisect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import accumulate
from typing import Final, Literal, NoReturn, TypeAlias

from truepose.domain.correction import UncorrectedTarget, place
from truepose.domain.errors import ConfigurationError
from truepose.exchange.errors import BadValueError, InputFileError, UnreadableFileError
from truepose.exchange.quantities import limits_of
from truepose.messages.message import Message, Text, message

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
    spoken: Message | None = None  # a name that the reader made, for people; None: it stands in the file

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
                "program is for another robot."
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


_MOST_NAMES: Final = 3  # that a sentence lists


@dataclass(frozen=True, slots=True)
class LeftAlone:
    """Something that is left alone, and the targets that serve for it."""

    target: UncorrectedTarget
    serving: tuple[int, ...] = ()  # indices among the targets

    def beside(self, corrected: Mapping[int, str]) -> UncorrectedTarget:
        """Return it with the names of the targets that serve for it and are corrected themselves."""
        names = list(dict.fromkeys(corrected[index] for index in self.serving if index in corrected))
        if not names:
            return self.target
        reason, listed, more = self.target.reason, ", ".join(names[:_MOST_NAMES]), len(names) - _MOST_NAMES
        if more > 0:
            told = message("left.also_corrected_more", reason=reason, names=listed, more=more)
        else:
            told = message("left.also_corrected", reason=reason, names=listed)
        return replace(self.target, reason=told)


@dataclass(frozen=True, slots=True)
class Program:
    """A robot program as it was read; `data` is the file, `again` reads the same file with other numbers."""

    name: str
    format: str
    data: bytes = field(repr=False)
    targets: tuple[ProgramTarget, ...]
    motions: tuple[Motion, ...]
    set_aside: tuple[LeftAlone, ...]
    again: Callable[[bytes], "Program"] | None = field(default=None, repr=False, compare=False)

    @property
    def left_alone(self) -> tuple[UncorrectedTarget, ...]:
        """What is left alone, as far as the program tells: where every target can be corrected."""
        return self.left_beside(range(len(self.targets)))

    def left_beside(self, corrected: Iterable[int]) -> tuple[UncorrectedTarget, ...]:
        """Return what is left alone where the targets of these indices are corrected."""
        # What could not be corrected in the end was named here as corrected, beside its own line that says
        # that it is left alone.
        names = {index: self.targets[index].name for index in corrected}
        return tuple(one.beside(names) for one in self.set_aside)


class TargetConventions(StrEnum):
    """What the targets of a program are given in, beside its own work objects."""

    BASE = "base"  # of the robot
    WORLD = "world"  # of the readings that the model was made from


@dataclass(frozen=True, slots=True)
class ProgramOptions:
    """What whoever has a program corrected says of it beside the file."""

    meant: TargetConventions = TargetConventions.BASE
    defined: Mapping[str, Pose] = field(
        default_factory=dict
    )  # tools (in the flange) and work objects that it only names
    coupled: bool = False  # joint 3 of FANUC is counted from the horizontal: its joints may be corrected
    branch: int | None = None  # of poses whose branch the file says in words that are not understood


_LIMITS: Final = limits_of("number")
_LONGEST_SHOWN: Final = 40
_MOST_SHIFT: Final = 400.0  # of the point: what is shifted further is 0, or larger than any number
_LINE_END: Final = re.compile(r"\r\n|\n|\r")
UTF_16_MARKS: Final = (b"\xff\xfe", b"\xfe\xff")
_MARK: Final = b"\xef\xbb\xbf"  # that a text is UTF-8


class Source:
    """A program as text, and behind it other files that belong to it.

    Parameters
    ----------
    data : bytes
        The file.
    name : str
        Of the file, for error messages.
    beside : mapping of str to bytes, optional
        Other files of the same program by name; lines are counted on through all of them.

    Raises
    ------
    UnreadableFileError
        A file is no text of one byte a character.
    """

    def __init__(self, data: bytes, name: str, beside: Mapping[str, bytes] | None = None) -> None:
        self.data = data
        self.name = name
        files = {name: data, **(beside or {})}
        for file, content in files.items():
            _require_text(file, content)
        # The own file comes first and unchanged: places in the text are then places in its bytes, at which
        # numbers are replaced.
        parts = [data, *(content.removeprefix(_MARK) for content in list(files.values())[1:])]
        self._bytes = b"\n".join(parts)
        self.text = self._bytes.decode("latin-1")
        self._lines = [0, *(end.end() for end in _LINE_END.finditer(self.text))]
        begins = accumulate((len(part) + 1 for part in parts[:-1]), initial=0)
        self._begins = [(self.line(begin), file) for begin, file in zip(begins, files, strict=True)]

    @property
    def start(self) -> int:
        """Where the text begins, behind a byte order mark."""
        return len(_MARK) if self.data.startswith(_MARK) else 0

    @property
    def n_lines(self) -> int:
        """Lines of the text; behind the last line end stands one more, which is empty."""
        return len(self._lines)

    def line(self, at: int) -> int:
        """Return the 1-based line of a place, counted on through the files beside."""
        return bisect.bisect_right(self._lines, at)

    def file_and_line(self, line: int) -> tuple[str, int]:
        """Return the file of a line, and its number there."""
        begin, file = next(entry for entry in reversed(self._begins) if entry[0] <= line)
        return file, line - begin + 1

    def is_own(self, line: int) -> bool:
        """Whether a line is of the program itself, not of a file beside."""
        return len(self._begins) == 1 or line < self._begins[1][0]

    def said(self, line: int) -> str:
        """Return how the name of a frame tells its line."""
        file, number = self.file_and_line(line)
        return f"line {number}" if self.is_own(line) else f"line {number} of {file}"

    def place(self, line: int) -> Message:
        """Return how a sentence names a line."""
        file, number = self.file_and_line(line)
        return place(number, None if self.is_own(line) else file)

    def line_span(self, line: int) -> tuple[int, int]:
        """Return where a 1-based line begins and where it ends, before its line end."""
        start = self._lines[line - 1]
        end = self._lines[line] if line < len(self._lines) else len(self.text)
        return start, start + len(self.text[start:end].rstrip("\r\n"))

    def shown(self, start: int, end: int) -> str:
        """Return a piece of the text as a person reads it, on one line."""
        piece = self._bytes[start:end]
        try:
            text = piece.decode("utf-8")
        except UnicodeDecodeError:
            text = piece.decode("latin-1")
        return " ".join(text.split())

    def number(self, start: int, end: int) -> Number:
        """Return the number that is written between two places; refuses one that none can be."""
        written = "".join(self.text[start:end].split())  # a sign may stand apart
        value = float(written)
        if not _LIMITS.accepts(value):
            shown = written if len(written) <= _LONGEST_SHOWN else f"{written[:_LONGEST_SHOWN]}..."
            self.refuse(_LIMITS.fault(value, shown), start)
        digits, _, exponent = written.lower().partition("e")
        _, _, places = digits.partition(".")
        shift = max(-_MOST_SHIFT, min(_MOST_SHIFT, float(exponent or 0)))
        return Number(start, end, value, max(len(places) - int(shift), 0))

    def fail(self, sentence: str, at: int, kind: type[InputFileError] = UnreadableFileError) -> NoReturn:
        """Raise `kind` at a place."""
        line = self.line(at)
        file, number = self.file_and_line(line)
        raise kind(sentence, file=file, line=number, column=str(at - self._lines[line - 1] + 1))

    def refuse(self, sentence: str, at: int) -> NoReturn:
        """Raise BadValueError at a place."""
        self.fail(sentence, at, BadValueError)


def _require_text(file: str, data: bytes) -> None:
    if data.startswith(UTF_16_MARKS):
        sentence = "the text is UTF-16; save the file as UTF-8 or in the encoding of the controller"
    elif b"\0" in data:
        sentence = "this is a binary file; the program as text is required"
    elif not data.strip():
        sentence = "the file is empty; a program is required"
    else:
        return
    raise UnreadableFileError(sentence, file=file)
