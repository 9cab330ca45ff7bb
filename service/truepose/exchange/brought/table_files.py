"""Tables of any program on the command line: the same guesses, told before anything is written."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

from truepose.domain.sentences import Sentence, said
from truepose.exchange.brought.choices import Choices
from truepose.exchange.brought.files.parcel import MOST_FILES
from truepose.exchange.brought.reading import Reading, read_brought
from truepose.exchange.brought.understood import FileSeen, Understood
from truepose.exchange.errors import UnsafeArchiveError
from truepose.exchange.input_file import read_bytes
from truepose.identification.verdict.changes import Change

_SURE: Final = frozenset({"certain", "said"})


def read_tables(path: Path, choices: Choices, *, accept_changes: bool) -> Reading:
    """Read a table, a zip or what lies in a folder; raises InputFileError.

    With `accept_changes` the changes of convention that make the robot fit are made, and noted.
    """
    paths = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
    if len(paths) > MOST_FILES:
        raise UnsafeArchiveError(
            f"{len(paths)} files are more than the {MOST_FILES} that are read", file=path.name
        )
    files = {one.name: read_bytes(one) for one in paths}
    found = read_brought(files, choices)
    robot = found.understood.robot
    if not accept_changes or robot is None or not robot.offered:
        return found
    changes = tuple(Change(one.kind, one.first, one.second, one.amount) for one in robot.offered)
    return read_brought(files, replace(choices, robot=robot.key, changes=changes))


def told(understood: Understood) -> Iterator[Sentence]:
    """Say what was taken for what, where that is not certain, which robot it is, and what is asked."""
    for file in understood.files:
        yield from _of_file(file)
    robot = understood.robot
    if robot is not None:
        yield said("bring.told.robot", robot=robot.name, reason=robot.reason)
        for change in robot.offered:
            yield said("bring.told.offered", change=change.sentence)
    yield from understood.notes


def _of_file(file: FileSeen) -> Iterator[Sentence]:
    for number, column in enumerate(file.columns, start=1):
        if column.certainty not in _SURE and column.meaning.column:
            yield said(
                "bring.told.column",
                file=file.name,
                heading=column.heading or str(number),
                column=column.meaning.column,
                unit=column.meaning.unit or "-",
                reason=column.reason,
            )
