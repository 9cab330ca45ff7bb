"""Files to be imported: archives opened, each file told by its name and its first words; the example."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import PurePosixPath
from typing import Final

from truepose.exchange.campaigns.folder import DESCRIPTION, TEXT_TABLES
from truepose.exchange.campaigns.zip_file import TOTAL_LIMIT_BYTES, read_zip_files
from truepose.exchange.errors import InputFileError, UnreadableFileError, UnsafeArchiveError
from truepose.exchange.import_wizard.dialogue import Choices, Kind
from truepose.exchange.import_wizard.sheet import Sheet, decode_text, lines_of, read_sheet
from truepose.exchange.import_wizard.workbook import is_workbook, read_workbook
from truepose.exchange.robots.named import is_robot_file
from truepose.messages.message import Text, message

MOST_FILES: Final = 200
_TABLES: Final = TEXT_TABLES | {""}
_HIDDEN: Final = ("__MACOSX", ".", "~$", "Thumbs.db")


@dataclass(frozen=True, slots=True)
class Piece:
    """A file, and its table if it is one."""

    name: str  # without folders
    data: bytes
    kind: Kind
    sheet: Sheet | None = None
    why_not: Text = ""  # it is not read
    fault: InputFileError | None = None


def unpack_files(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return files by their plain names, those of archives and sheets of workbooks too.

    Raises InputFileError.
    """
    found: dict[str, bytes] = {}
    for path, data in files.items():
        inside = read_zip_files(data, path) if _is_archive(path, data) else {path: data}
        for member, content in inside.items():
            if not _hidden(member):
                found |= _tables_of(_free_name(_plain(member), found), content, found)
                _require_few(found)
    return found


def _require_few(found: Mapping[str, bytes]) -> None:
    # As they come: of archives each is within its limits, and all of them need not be.
    if len(found) > MOST_FILES:
        raise UnsafeArchiveError(f"more than {MOST_FILES} files, which is the limit", file="upload")
    if sum(map(len, found.values())) > TOTAL_LIMIT_BYTES:
        raise UnsafeArchiveError(f"the content exceeds {TOTAL_LIMIT_BYTES // 2**20} MB", file="upload")


def _tables_of(name: str, data: bytes, taken: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the sheets of a workbook as files of their own; of another file, or a damaged one, itself."""
    sheets: dict[str, bytes] = {}
    with contextlib.suppress(UnreadableFileError):  # `pieces` says why
        for title, text in read_workbook(data, name).items() if is_workbook(name, data) else ():
            sheets[_free_name(title, {**taken, **sheets})] = text
    return sheets or {name: data}


def _is_archive(path: str, data: bytes) -> bool:
    # By both: a workbook begins like an archive, and a table may be called one.
    return path.lower().endswith(".zip") and data.startswith(b"PK")


def _hidden(path: str) -> bool:
    return any(part.startswith(_HIDDEN) for part in PurePosixPath(path.replace("\\", "/")).parts)


def _plain(path: str) -> str:
    """Return the name of a file, whatever system its path is of."""
    name = PurePosixPath(path.replace("\\", "/")).name
    return "".join(letter for letter in name if letter.isprintable())[:200] or "file"


def _free_name(name: str, taken: Mapping[str, bytes]) -> str:
    """Return a name that no other file has: two folders may each have a `points.csv`."""
    again, free = 2, name
    while free in taken:
        path = PurePosixPath(name)
        again, free = again + 1, f"{path.stem} ({again}){path.suffix}"
    return free


def pieces(files: Mapping[str, bytes], choices: Choices) -> tuple[Piece, ...]:
    """Return what each file is."""
    return tuple(_piece(name, data, choices) for name, data in files.items())


def _piece(name: str, data: bytes, choices: Choices) -> Piece:
    edits = choices.of(name).edits
    if PurePosixPath(name).name.lower() == DESCRIPTION:
        return Piece(name, with_edits(name, data, edits), "description")
    if is_robot_file(name):
        return Piece(name, data, "robot")
    try:
        if is_workbook(name, data):
            # Sheets of a workbook are files of their own by now. One that is still there is empty or damaged;
            # where it is damaged, reading it once more says how.
            read_workbook(data, name)
        if PurePosixPath(name).suffix.lower() not in _TABLES:
            return Piece(name, data, "other", why_not=message("bring.file.other"))
        return Piece(name, data, "table", read_sheet(name, data, edits))
    except InputFileError as error:
        return Piece(name, data, "other", why_not=str(error), fault=error)


def with_edits(name: str, data: bytes, edits: Mapping[int, str | None]) -> bytes:
    """Return the text of a file with lines that somebody corrected; one that is left out is blank."""
    if not edits:
        return data
    lines = lines_of(name, decode_text(name, data))
    told = [edits.get(number, line) or "" for number, line in enumerate(lines, start=1)]
    return "\n".join(told).encode()


_NAMES: Final = ("campaign.json", "left arm.csv", "left arm check.csv")


def example_files() -> dict[str, bytes]:
    """Return its files by name: readings of a simulated robot, as it says of itself."""
    folder = files("truepose.exchange.import_wizard") / "example"
    return {name: (folder / name).read_bytes() for name in _NAMES}
