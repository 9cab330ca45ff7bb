"""What `truepose` says by itself: what it is for, and which command comes next in a folder."""

import json
import shlex
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final, TypeAlias

from truepose.exchange.campaigns.folder import DESCRIPTION, TABLES
from truepose.exchange.models.document import FORMAT
from truepose.exchange.programs.formats import FORMATS

_PROGRAMS: Final = frozenset(suffix for known in FORMATS for suffix in known.suffixes) - TABLES - {".json"}
_LOOKED_AT: Final = 200  # files of a folder
_LARGEST_BYTES: Final = 4 * 2**20

Step: TypeAlias = tuple[str, str]  # what was found, the command that comes next

_ABOUT: Final = (
    "truepose measures industrial robots, identifies their true model, finds the causes of remaining errors "
    "and corrects programs.\n"
)
_ALL: Final = "All commands: truepose --help\n"
_BEGINNING: Final[tuple[Step, ...]] = (
    ("See the whole process on a simulated robot, in a minute", "truepose demo"),
    ("Work in the browser: import readings, plan a session", "truepose serve"),
    ("Import readings from a table as a campaign", "truepose import READINGS.csv --out CAMPAIGN"),
)


def introduction(folder: Path) -> str:
    """Return what truepose is and what to do next with what lies in a folder, as lines to print."""
    try:
        steps = tuple(_steps(folder)) or _BEGINNING
    except OSError:  # a folder that is gone, or that may not be read
        steps = _BEGINNING
    return "\n".join([_ABOUT, *(f"{found}:\n  {command}\n" for found, command in steps), _ALL])


def _steps(folder: Path) -> Iterator[Step]:
    files = _files(folder)
    campaigns = list(_campaigns(folder, files))
    models = [file for file in files if _is_model(file)]
    for campaign in campaigns[:1]:
        told = _shown(campaign, folder)
        if not models:
            yield f"{told} is a campaign", f"truepose identify {told} --model-out model.json"
        yield (
            f"Find the errors of its model and their causes ({told})",
            f"truepose diagnose {told} --report diagnosis.html",
        )
    for model in models[:1]:
        yield from _with_model(_shown(model, folder), files, folder)
    if not campaigns and not models:
        yield from _of_readings(files, folder)
    for cell in [file for file in files if _is_cell(file)][:1]:
        told = _shown(cell, folder)
        yield f"{told} describes a cell", f"truepose serve --cell {told}"


def _with_model(model: str, files: list[Path], folder: Path) -> Iterator[Step]:
    tables = [file for file in files if file.suffix.lower() == ".csv"]
    programs = [file for file in files if file.suffix.lower() in _PROGRAMS]
    points = _shown(tables[0], folder) if tables else "POINTS.csv"
    yield (
        f"{model} is a model: validate it on held-out readings",
        f"truepose validate {model} {points}",
    )
    program = _shown(programs[0], folder) if programs else "PROGRAM"
    yield "Correct a robot program with the model", f"truepose correct {model} {program} --out corrected"


def _of_readings(files: list[Path], folder: Path) -> Iterator[Step]:
    for table in [file for file in files if file.suffix.lower() in TABLES][:1]:
        told = _shown(table, folder)
        yield (
            f"{told} may contain readings: import it as a campaign",
            f"truepose import {told} --out campaign",
        )


def _campaigns(folder: Path, files: list[Path]) -> Iterator[Path]:
    for place in (folder, *sorted(one for one in folder.iterdir() if one.is_dir())[:_LOOKED_AT]):
        if (place / DESCRIPTION).is_file():
            yield place
    yield from (file for file in files if file.suffix.lower() == ".zip" and _holds_campaign(file))


def _holds_campaign(file: Path) -> bool:
    try:
        with zipfile.ZipFile(file) as archive:
            return any(Path(name).name == DESCRIPTION for name in archive.namelist())
    except (OSError, zipfile.BadZipFile):
        return False


def _is_model(file: Path) -> bool:
    if file.suffix.lower() != ".json":
        return False
    try:
        said = json.loads(file.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(said, dict) and said.get("format") == FORMAT


def _is_cell(file: Path) -> bool:
    if file.suffix.lower() != ".toml":
        return False
    try:
        said = tomllib.loads(file.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return "robot" in said and "device" in said


def _files(folder: Path) -> list[Path]:
    found = sorted(one for one in folder.iterdir() if one.is_file() and not one.name.startswith("."))
    return [one for one in found[:_LOOKED_AT] if one.stat().st_size <= _LARGEST_BYTES]


def _shown(path: Path, folder: Path) -> str:
    return shlex.quote(str(path.relative_to(folder)))
