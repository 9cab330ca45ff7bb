"""The formats of robot programs and position lists that are read and written, each one line."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import PurePath
from typing import Final

from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.programs.controller_rules import Confdata, Nearest, Rule, StatedBranch, StatusAndTurn
from truepose.exchange.programs.languages import (
    fanuc_ls,
    gcode,
    inform,
    json_list,
    krl,
    rapid,
    ur_script,
    val3,
)
from truepose.exchange.programs.parsed_program import Draft
from truepose.exchange.programs.program import Program, Source

_FULL: Final = "5e-7 mm, 5e-10 deg"
_SINGLE: Final = f"{_FULL}; the controller itself keeps 7 digits"


@dataclass(frozen=True, slots=True)
class Format:
    """A format, and how far it can say a place."""

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Draft], None]
    rounding: str
    maker: str = ""  # of the controllers that read it, as names of robots have it
    has_files_beside: bool = False  # whether a program may be several files
    rule: Rule = field(default_factory=StatedBranch)  # by which the controller chooses joints


FORMATS: Final = (
    Format("ABB RAPID", (".mod", ".sys", ".prg"), rapid.read, _SINGLE, "ABB", True, Confdata()),
    Format("KUKA KRL", (".src", ".dat"), krl.read, _SINGLE, "KUKA", True, StatusAndTurn()),
    Format("FANUC LS", (".ls",), fanuc_ls.read, "0.0005 mm, 0.0005 deg", "FANUC"),
    Format(
        "URScript", (".script",), ur_script.read, "5e-7 mm, 5e-12 rad", "Universal Robots", rule=Nearest()
    ),
    Format("targets in JSON", (".json",), json_list.read, _FULL, rule=Nearest()),
    Format("G-code", (".nc", ".gcode", ".cnc", ".tap"), gcode.read, _FULL),
    Format("Yaskawa INFORM", (".jbi",), inform.read, "0.0005 mm, 0.005 deg, or as in the job", "Yaskawa"),
    Format("Staubli VAL3", (".dtx",), val3.read, _FULL, "Staubli"),
)


def read_program(
    data: bytes, name: str, *, beside: Mapping[str, bytes] | None = None, angles: str | None = None
) -> Program:
    """Read a robot program or a position list; the ending of its name says the format.

    Parameters
    ----------
    data : bytes
        The file.
    name : str
        Of the file.
    beside : mapping of str to bytes, optional
        Other files of the same program by name: modules that declare its tools and work objects, the
        KUKA program (.src) that moves to the points of a data list (.dat). They tell how the targets
        of this file are used; their own targets are not among the answer. In formats whose programs
        are one file they do not matter.
    angles : {"xyz", "zyx", "fixed xyz"}, optional
        Axes of the words A, B, C of a list of G-code, which does not say them: see
        `pose_notation.turns_in_degrees`. The other formats say it themselves.

    Raises
    ------
    InputFileError
        The format is unknown, or the file is broken: file, line, and place in the line.
    """
    found = format_of(name)
    draft = Draft(Source(data, name, beside if found.has_files_beside else None), angles)
    found.read(draft)
    again = partial(read_program, name=name, beside=beside, angles=angles)
    return replace(draft.program(found.name), again=again)


def format_of(name: str) -> Format:
    """Return the format of a file by the ending of its name; raises UnreadableFileError."""
    suffix = PurePath(name).suffix.lower()
    for known in FORMATS:
        if suffix in known.suffixes:
            return known
    raise UnreadableFileError(f"unknown file extension; {supported_files()}", file=name)


def supported_files() -> str:
    """Return which files of targets are read, for the end of a sentence."""
    listed = ", ".join(f"{known.name} ({' '.join(known.suffixes)})" for known in FORMATS)
    return f"supported files are tables (.csv), {listed}"
