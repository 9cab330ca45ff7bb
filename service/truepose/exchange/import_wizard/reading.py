"""Files of any program, read as far as it goes: what they are, what is asked, and the campaign."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any, Final

import numpy as np

from truepose.domain.campaign import Campaign
from truepose.domain.robot import Robot
from truepose.exchange.campaigns.description import read_day, unknown_nests
from truepose.exchange.campaigns.folder import DESCRIPTION, campaign_from, campaign_from_arrays
from truepose.exchange.document import Node, json_document, read_bytes
from truepose.exchange.errors import (
    InputFileError,
    MissingEntryError,
    MissingFileError,
    UnreadableFileError,
    UnsafeArchiveError,
    WrongUnitError,
)
from truepose.exchange.import_wizard import display
from truepose.exchange.import_wizard.columns import ImportedTable
from truepose.exchange.import_wizard.dialogue import (
    OWN_ROBOT,
    Choices,
    DetectedFile,
    Question,
    RobotSeen,
    Understood,
)
from truepose.exchange.import_wizard.display import files_seen, notes_on
from truepose.exchange.import_wizard.files import MOST_FILES, Piece, pieces, unpack_files, with_edits
from truepose.exchange.import_wizard.robots import Found, apply_changes, robot_of
from truepose.exchange.import_wizard.tables import (
    DetectedTable,
    by_role,
    detected_tables,
    has_positions,
    n_joints,
    positions_of,
    scatter_of_revisits_mm,
    whole_or_0,
)
from truepose.exchange.robots.named import campaign_keys
from truepose.identification.verdict.conventions import Change
from truepose.messages.message import Message, message

SPREADS: Final = ("u_mm", "cxx", "u_along_mm")
_OF_ANOTHER_FORM: Final = (MissingEntryError, MissingFileError, UnreadableFileError, WrongUnitError)
_OF_THE_FOLDER: Final = frozenset({"files", "format", "dhm_nominal"})  # keys that are made anew
_ROLES_READ: Final = ("calibration", "validation", "legs", "validation_legs")


@dataclass(frozen=True, slots=True)
class Reading:
    """What was understood, and the campaign where nothing is left to ask."""

    understood: Understood
    campaign: Campaign | None = None


@dataclass(frozen=True, slots=True)
class _Gathered:
    """Everything that a campaign is made of."""

    pieces: tuple[Piece, ...]
    sheets: tuple[DetectedTable, ...]
    tables: Mapping[str, ImportedTable]  # by role
    stated: Mapping[str, object]  # keys of a description that was brought
    choices: Choices

    @property
    def identifying(self) -> ImportedTable:
        return self.tables.get("calibration") or self.tables["legs"]


def read_imported_files(files: Mapping[str, bytes], choices: Choices | None = None) -> Reading:
    """Read the files that somebody brought.

    Parameters
    ----------
    files : mapping of str to bytes
        By their paths; archives of folders among them.
    choices : Choices, optional
        What was said of them since.

    Returns
    -------
    Reading
        Faults and questions are part of it.

    Raises
    ------
    InputFileError
        An archive cannot be opened, or no honest program writes it.
    """
    said_so = choices or Choices()
    found = pieces(unpack_files(files), said_so)
    return _as_a_folder(found, said_so) or _guessed(found, said_so)


def _as_a_folder(found: tuple[Piece, ...], choices: Choices) -> Reading | None:
    """Return a campaign folder read to the letter; None where there is none, or of another form."""
    # Whoever has chosen a robot, a change or a column says that the files do not mean what the format would
    # have them mean.
    if choices.changes or choices.robot not in {None, OWN_ROBOT}:
        return None
    if any(one.columns or one.role for one in choices.files.values()):
        return None
    texts = {piece.name: _text(piece, choices) for piece in found}

    def load(name: str) -> bytes:
        if name not in texts:
            raise MissingFileError("this file is not among the imported files", file=name)
        return texts[name]

    try:
        campaign = campaign_from(load)
    # What lacks a column, a file or a unit may be another program's, and is guessed. A bad value in a folder
    # of this format is a fault, and is shown as one.
    except _OF_ANOTHER_FORM:
        return None
    # A fault is part of the answer: the page shows its line and lets a person correct it.
    except InputFileError as error:
        return Reading(Understood(files_seen(found, ()), fault=display.display_fault(error, found, ())))
    return _of_a_folder(found, campaign, choices)


def _text(piece: Piece, choices: Choices) -> bytes:
    if piece.kind == "description":
        return piece.data  # corrected already
    return with_edits(piece.name, piece.data, choices.of(piece.name).edits)


def _of_a_folder(found: tuple[Piece, ...], campaign: Campaign, choices: Choices) -> Reading:
    files = [
        replace(one, reason=message("bring.file.format")) if one.kind == "table" else one
        for one in files_seen(found, ())
    ]
    tables = [getattr(campaign, role) for role in _ROLES_READ]
    understood = Understood(
        tuple(files),
        RobotSeen(OWN_ROBOT, campaign.robot.name, message("bring.robot.file"), fits=True),
        readings=sum(len(table) for table in tables if table is not None),
    )
    return _finished(
        campaign, replace(choices, measured_on=choices.measured_on or campaign.measured_on), understood
    )


def _finished(campaign: Campaign, choices: Choices, understood: Understood) -> Reading:
    """Return the reading of a campaign that is whole but for the day, which only people know."""
    day = choices.measured_on
    serials: dict[str, Any] = {
        "robot_serial_number": choices.robot_serial_number or campaign.robot_serial_number,
        "instrument_serial_number": choices.instrument_serial_number or campaign.instrument_serial_number,
    }
    seen = replace(
        understood,
        questions=(*understood.questions, *_of_day(choices)),
        measured_on=None if day is None else day.isoformat(),
        simulated=bool(campaign.simulated),
        **serials,
    )
    noted = replace(campaign, measured_on=day, notes=(*campaign.notes, *choices.notes), **serials)
    return Reading(seen, noted if seen.ready else None)


def _of_day(choices: Choices) -> list[Question]:
    return [] if choices.measured_on or choices.undated else [Question("day", message("bring.ask.day"))]


def _guessed(found: tuple[Piece, ...], choices: Choices) -> Reading:
    sheets = detected_tables(found, choices)
    understood = Understood(files_seen(found, sheets), notes=tuple(notes_on(sheets)))
    tables: dict[str, ImportedTable] = {}
    try:
        description = _described(found)
        stated = _stated(description)
        tables = by_role(sheets)
        missing = _missing(sheets, tables)
        if missing is not None:
            return Reading(replace(understood, questions=(missing,)))
        dated = replace(choices, measured_on=choices.measured_on or _day(description))
        return _read(_Gathered(found, sheets, tables, stated, dated), understood)
    except InputFileError as error:
        return Reading(replace(understood, fault=display.display_fault(error, found, sheets)))


def _described(found: Sequence[Piece]) -> Node | None:
    """Return the description that was brought, if one was: of one name there is one piece."""
    brought = (json_document(piece.name, piece.data) for piece in found if piece.name == DESCRIPTION)
    return next(brought, None)


def _stated(description: Node | None) -> dict[str, object]:
    """Return what a description says; what it says of its tables is made anew."""
    said = {} if description is None else description.entries()
    return {name: value for name, value in said.items() if name not in _OF_THE_FOLDER}


def _day(description: Node | None) -> date | None:
    node = None if description is None else description.optional("measured_on")
    return None if node is None else read_day(node)


def _missing(sheets: Sequence[DetectedTable], tables: Mapping[str, ImportedTable]) -> Question | None:
    """Return the question for what no campaign can do without; None where it is there."""
    identifying = tables.get("calibration") or tables.get("legs")
    if not sheets:
        return Question("tables", message("bring.ask.tables"))
    if identifying is None:
        return Question("readings", message("bring.ask.readings"))
    if not n_joints(identifying.columns):
        return Question("joints", message("bring.ask.joints"))
    if "length_mm" not in identifying.columns and not has_positions(identifying.columns):
        return Question("readings", message("bring.ask.axes"))
    return None


def _read(gathered: _Gathered, understood: Understood) -> Reading:
    found = robot_of(gathered.pieces, gathered.identifying, gathered.choices)
    scatter = _scatter_mm(gathered.identifying)
    questions = [*_of_robot(found), *_of_uncertainty(gathered, scatter)]
    seen = replace(
        understood,
        robot=found.seen,
        u_mm=scatter,
        readings=sum(len(table) for table in gathered.tables.values()),
        questions=tuple(questions),
    )
    # Without a robot, or without an uncertainty, no table can be read further: what would come next are
    # faults that are none.
    if found.robot is None or any(one.about in {"robot", "uncertainty"} for one in questions):
        return Reading(replace(seen, questions=(*questions, *_of_day(gathered.choices))))
    try:
        return _finished(_campaign(gathered, found.robot, scatter), gathered.choices, seen)
    except InputFileError as error:
        return Reading(replace(seen, fault=display.display_fault(error, gathered.pieces, gathered.sheets)))


def _of_robot(found: Found) -> list[Question]:
    if found.question is None:
        return []
    offered = found.seen is not None and found.seen.offered
    return [Question("change" if offered else "robot", found.question)]


def _of_uncertainty(gathered: _Gathered, scatter_mm: float | None) -> list[Question]:
    said_so = all(any(name in table.columns for name in SPREADS) for table in gathered.tables.values())
    known = said_so or gathered.choices.u_mm is not None or scatter_mm is not None
    return [] if known else [Question("uncertainty", message("bring.ask.uncertainty"))]


def _scatter_mm(table: ImportedTable) -> float | None:
    """Return what places scatter that were measured again, where no column says how uncertain they are."""
    columns = table.columns
    if "repeat_of" not in columns or "u_mm" in columns or not has_positions(columns):
        return None
    config, repeat_of = (columns[name].astype(float) for name in ("config", "repeat_of"))
    return scatter_of_revisits_mm(positions_of(columns), whole_or_0(columns["nest"]), config, repeat_of)


def _campaign(gathered: _Gathered, robot: Robot, scatter_mm: float | None) -> Campaign:
    """Return the campaign; raises InputFileError at the place of the first fault."""
    choices = gathered.choices
    filled = {
        role: _with_uncertainty(table, choices.u_mm or scatter_mm) for role, table in gathered.tables.items()
    }
    meant = {role: apply_changes(robot, table.columns, choices.changes) for role, table in filled.items()}
    # What a description states goes before what is assumed.
    keys = {**_keys(next(iter(meant.values()))[0], filled.values()), **gathered.stated}
    if scatter_mm is not None and choices.u_mm is None:
        # Places that are measured again scatter by the arm and by the instrument: the arm's own part must not
        # count a second time.
        keys["u_includes_repeatability"] = True
    try:
        return campaign_from_arrays(keys, {role: columns for role, (_, columns) in meant.items()})
    except InputFileError as error:
        if error.file in filled:
            raise display.in_its_file(error, filled[error.file]) from error
        raise


def _with_uncertainty(table: ImportedTable, u_mm: float | None) -> ImportedTable:
    if u_mm is None or "u_mm" in table.columns:
        return table
    return replace(table, columns={**table.columns, "u_mm": np.full(len(table), u_mm)})


def _keys(robot: Robot, tables: Iterable[ImportedTable]) -> dict[str, Any]:
    """Return the keys of `campaign.json`: those of the robot, and nests and a base that are to be found."""
    ends = [
        table.columns[name].astype(float)
        for table in tables
        for name in ("nest", "tool_point")
        if name in table.columns
    ]
    return {
        "tool_nests_mm": unknown_nests(ends),
        "tool_nest_u_mm": None,
        "base_in_world_nominal": None,
        **campaign_keys(robot),
    }


_SURE: Final = frozenset({"certain", "said"})


def read_tables(path: Path, choices: Choices, *, accept_changes: bool) -> Reading:
    """Read a table, a zip or what lies in a folder; raises InputFileError.

    With `accept_changes` the changes of convention that make the robot fit are made, and noted.
    """
    paths = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
    if len(paths) > MOST_FILES:
        raise UnsafeArchiveError(f"{len(paths)} files exceed the limit of {MOST_FILES}", file=path.name)
    files = {one.name: read_bytes(one) for one in paths}
    found = read_imported_files(files, choices)
    robot = found.understood.robot
    if not accept_changes or robot is None or not robot.offered:
        return found
    changes = tuple(Change(one.kind, one.first, one.second, one.amount) for one in robot.offered)
    return read_imported_files(files, replace(choices, robot=robot.key, changes=changes))


def detection_remarks(understood: Understood) -> Iterator[Message]:
    """Say what was taken for what, where that is not certain, which robot it is, and what is asked."""
    for file in understood.files:
        yield from _of_file(file)
    robot = understood.robot
    if robot is not None:
        yield message("bring.told.robot", robot=robot.name, reason=robot.reason)
        for change in robot.offered:
            yield message("bring.told.offered", change=change.sentence)
    yield from understood.notes


def _of_file(file: DetectedFile) -> Iterator[Message]:
    for number, column in enumerate(file.columns, start=1):
        if column.certainty not in _SURE and column.meaning.column:
            yield message(
                "bring.told.column",
                file=file.name,
                heading=column.heading or str(number),
                column=column.meaning.column,
                unit=column.meaning.unit or "-",
                reason=column.reason,
            )
