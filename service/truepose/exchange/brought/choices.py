"""What somebody said about the files that they brought."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Any, Final

from truepose.exchange.brought.guessing.quantities import Meaning
from truepose.identification.verdict.changes import Change

ROLES: Final = ("calibration", "validation", "legs", "validation_legs", "nothing")
OWN_ROBOT: Final = "file"  # the robot that one of the files describes


@dataclass(frozen=True, slots=True)
class FileChoice:
    """What was said of one file."""

    role: str | None = None  # of ROLES; None: nothing was said
    columns: Mapping[int, Meaning] = field(default_factory=dict)  # by column, from 0
    edits: Mapping[int, str | None] = field(default_factory=dict)  # by line; None: it is left out


@dataclass(frozen=True, slots=True)
class Choices:
    """What was said of all of them."""

    files: Mapping[str, FileChoice] = field(default_factory=dict)
    robot: str | None = None  # a shipped one, or OWN_ROBOT; None: it is found
    changes: tuple[Change, ...] = ()
    u_mm: float | None = None
    measured_on: date | None = None
    robot_serial_number: str = ""  # empty: nothing was said; so below
    instrument_serial_number: str = ""
    undated: bool = False  # the day may stay unknown: whoever asks is not made a record of
    notes: tuple[str, ...] = ()

    def of(self, file: str) -> FileChoice:
        """Return what was said of a file."""
        return self.files.get(file, FileChoice())


def choices_of(document: Mapping[str, Any], notes: Sequence[str] = ()) -> Choices:
    """Return choices from what requests send and drafts keep; it was checked where it came in."""
    day = document.get("measured_on")
    return Choices(
        files={name: _file(said) for name, said in (document.get("files") or {}).items()},
        robot=document.get("robot"),
        changes=tuple(Change(**change) for change in document.get("changes") or ()),
        u_mm=document.get("u_mm"),
        measured_on=None if day is None else date.fromisoformat(day),
        robot_serial_number=document.get("robot_serial_number") or "",
        instrument_serial_number=document.get("instrument_serial_number") or "",
        notes=tuple(notes),
    )


def _file(said: Mapping[str, Any]) -> FileChoice:
    columns = {int(at): Meaning(**meaning) for at, meaning in (said.get("columns") or {}).items()}
    edits: dict[int, str | None] = {int(line): text for line, text in (said.get("lines") or {}).items()}
    left_out = dict.fromkeys(said.get("left_out") or (), None)
    return FileChoice(said.get("role"), columns, edits | left_out)


def merged(before: Mapping[str, Any], said: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with what was said since, member by member; null takes one back (RFC 7396)."""
    found = dict(before)
    for key, value in said.items():
        if value is None:
            found.pop(key, None)
        elif isinstance(value, Mapping):
            found[key] = merged(found.get(key) or {}, value)
        else:
            found[key] = value
    return found
