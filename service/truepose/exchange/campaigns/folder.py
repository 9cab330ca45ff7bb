"""Campaign folder, format 1, in and out; the same of tables that a program has in memory."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings
from truepose.exchange.campaigns.description import (
    FORMAT,
    Description,
    description_document,
    read_description,
)
from truepose.exchange.document import GREATEST_BYTES, Node, json_document, read_bytes
from truepose.exchange.errors import MissingFileError, UnreadableFileError
from truepose.exchange.json_text import render_json
from truepose.exchange.tables.ballbar import (
    cup_text,
    fixture_text,
    leg_text,
    read_cup_table,
    read_fixture_table,
    read_leg_table,
    read_setup_table,
    setup_text,
)
from truepose.exchange.tables.contacts import (
    contact_text,
    distance_text,
    read_contact_table,
    read_distance_table,
    read_target_table,
    target_text,
)
from truepose.exchange.tables.points import (
    in_files,
    point_text,
    read_point_table,
    read_reference_table,
    reference_text,
)
from truepose.exchange.tables.table_reader import Arrays, TableData
from truepose.messages.message import Message, message

DESCRIPTION = "campaign.json"
# Suffixes of readings in columns: of text, and with those of workbooks.
TEXT_TABLES = frozenset({".csv", ".tsv", ".txt", ".dat", ".asc", ".pts", ".tab", ".prn"})
TABLES = TEXT_TABLES | {".xlsx"}
GREATEST_DESCRIPTION_BYTES = 4 * 2**20  # a thousand notes of a page each
Load = Callable[[str], bytes]
LoadTable = Callable[[str], TableData]


def read_campaign(folder: Path) -> Campaign:
    """Read a campaign folder.

    Raises
    ------
    InputFileError
        Its subclass says the fault; its text names file, line and column or key in one sentence.
    """
    if not folder.exists():
        raise MissingFileError("there is no such campaign folder", file=str(folder))
    if not folder.is_dir():
        raise UnreadableFileError(_no_campaign(folder), file=str(folder))
    return campaign_from(lambda name: _content(folder / name))


def _content(file: Path) -> bytes:
    """Return a file of a campaign; a description that is missing is named with its folder."""
    if file.name != DESCRIPTION:
        return read_bytes(file, most=GREATEST_BYTES)
    try:
        return read_bytes(file, most=GREATEST_DESCRIPTION_BYTES)
    except MissingFileError as error:
        raise MissingFileError("there is no such file", file=str(file)) from error


def _no_campaign(file: Path) -> str:
    said = "this is neither a campaign folder nor a zip file of a campaign folder"
    if file.suffix.lower() not in TABLES:
        return said
    return f"{said}, but a table; import it with `truepose import {file.name} --out CAMPAIGN`"


def write_campaign(campaign: Campaign, folder: Path) -> None:
    """Write a campaign folder; creates it where needed and replaces files of the same names.

    Reading it back gives an equal campaign to the digits stated in `tables.fields`, without what the
    format cannot hold: source, ranges, limits and rated payload of the robot.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in campaign_files(campaign).items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def campaign_from(load: Load) -> Campaign:
    """Read a campaign whose files `load` returns by name; it raises MissingFileError."""
    description = read_description(json_document(DESCRIPTION, load(DESCRIPTION)))
    return with_tables(description, load)


def _load_role(description: Description, role: str, load: LoadTable) -> TableData:
    try:
        return load(description.files[role])
    except MissingFileError as error:
        missing = f"file {description.files[role]} is not in the folder"
        raise MissingFileError(
            missing, file=DESCRIPTION, line=_line(description, role), key=f"files.{role}"
        ) from error


def _line(description: Description, role: str) -> int | None:
    return description.files_node.locate((*description.files_node.path, role))


def with_tables(description: Description, load: LoadTable) -> Campaign:
    """Return the campaign with its tables and everything that was ignored in them.

    `load` returns the table of a name that the description gives; raises an InputFileError.
    """
    campaign = description.campaign
    joints, nests = campaign.robot.n_joints, range(1, len(campaign.nests) + 1)
    tracker, fixed = campaign.tracker_position_mm, len(campaign.fixed_nests)
    readers: dict[str, Callable[[str, TableData], tuple[object, tuple[Message, ...]]]] = {
        "calibration": lambda file, data: read_point_table(file, data, joints, nests, tracker),
        "validation": lambda file, data: read_point_table(file, data, joints, nests, tracker),
        "reference": lambda file, data: read_reference_table(file, data, fixed),
        "legs": lambda file, data: read_leg_table(file, data, joints, nests),
        "validation_legs": lambda file, data: read_leg_table(file, data, joints, nests),
        "fixture": read_fixture_table,
        "setup": lambda file, data: read_setup_table(file, data, joints),
        "cups": read_cup_table,
        "targets": read_target_table,
        "contacts": lambda file, data: read_contact_table(file, data, joints, nests, campaign.targets),
        "validation_contacts": lambda file, data: read_contact_table(
            file, data, joints, nests, campaign.targets
        ),
        "target_distances": lambda file, data: read_distance_table(file, data, campaign.targets),
    }
    ignored: dict[Message, list[str]] = {}
    # Targets come first, which other tables name.
    for role in sorted(
        description.files, key=lambda role: role != "targets"
    ):  # one after the other: the text of a table is larger than the table
        table, clauses = readers[role](description.files[role], _load_role(description, role, load))
        campaign = replace(campaign, **{role: table})  # type: ignore[arg-type]  # a role is the field of its table
        for clause in clauses:
            ignored.setdefault(clause, []).append(description.files[role])
    sentences = (in_files(files, clause) for clause, files in ignored.items())
    return replace(
        campaign, ignored=(*campaign.ignored, *sentences, *_judged_by_themselves(description, campaign))
    )


def _judged_by_themselves(description: Description, campaign: Campaign) -> Iterator[Message]:
    """Say how many validation readings are calibration readings too: a copied file proves nothing."""
    if campaign.calibration is None or campaign.validation is None:
        return
    # Bit by bit: what was measured twice differs in its last digits, what was copied does not.
    identifying = {row.tobytes() for row in _readings(campaign.calibration)}
    shared = sum(row.tobytes() in identifying for row in _readings(campaign.validation))
    if shared:
        yield message(
            "ignored.judge_nothing",
            validation=description.files["validation"],
            shared=shared,
            readings=len(campaign.validation),
            calibration=description.files["calibration"],
        )


def _readings(points: PointReadings) -> FloatArray:
    """Return what makes a reading the same as another: joints, nest and position, one row each."""
    return np.column_stack([points.stops.joints_rad, points.nest, points.position_mm])


def campaign_files(campaign: Campaign) -> dict[str, str]:
    """Return the text of every file of the campaign folder, by name."""
    tables = {
        "calibration": campaign.calibration and point_text(campaign.calibration),
        "validation": campaign.validation and point_text(campaign.validation),
        "reference": campaign.reference and reference_text(campaign.reference),
        "legs": campaign.legs and leg_text(campaign.legs),
        "validation_legs": campaign.validation_legs and leg_text(campaign.validation_legs),
        "fixture": campaign.fixture and fixture_text(campaign.fixture),
        "setup": campaign.setup and setup_text(campaign.setup),
        "cups": campaign.cups and cup_text(campaign.cups),
        "targets": target_text(campaign.targets) if campaign.targets else None,
        "contacts": campaign.contacts and contact_text(campaign.contacts),
        "validation_contacts": campaign.validation_contacts and contact_text(campaign.validation_contacts),
        "target_distances": campaign.target_distances and distance_text(campaign.target_distances),
    }
    texts = {f"{role}.csv": text for role, text in tables.items() if isinstance(text, str)}
    files = {name.removesuffix(".csv"): name for name in texts}
    return {DESCRIPTION: render_json(description_document(campaign, files)) + "\n", **texts}


_NAME: Final = "campaign"  # where errors place a key


def campaign_from_arrays(keys: Mapping[str, object], tables: Mapping[str, Arrays]) -> Campaign:
    """Return the campaign, checked as one from a folder is.

    Parameters
    ----------
    keys : mapping
        Those of `campaign.json` but `format` and `files`, with lists and plain numbers.
    tables : mapping of str to mapping of str to ndarray
        By role, such as `calibration`: columns of shape (n,) by their names in the file format.

    Raises
    ------
    InputFileError
        With the key, or with role, row and column.
    """
    # The names of tables are their roles here: errors then say `calibration`, which is what the caller called
    # it.
    document = {**keys, "format": FORMAT, "files": {role: role for role in tables}}
    return with_tables(read_description(Node(_NAME, document, (), lambda path: None)), tables.__getitem__)
