"""Errors of reading and writing files.

ExchangeError
├── InputFileError           a file given by the user cannot be used; says where in it
│   ├── MissingFileError       it is not there
│   ├── UnreadableFileError    it is not what its name promises: not UTF-8, not CSV, JSON, TOML or zip
│   ├── MissingEntryError      a required column or key is absent
│   ├── WrongUnitError         a column or key is there in another unit
│   ├── BadValueError          a value cannot be meant
│   ├── NewerVersionError      it was written by a later program
│   ├── EditedFileError        it was edited after truepose wrote it
│   ├── ImplausibleModelError  it moves the tool further than is accepted
│   └── UnsafeArchiveError     an archive that no honest program writes
└── UnknownRobotError        no shipped robot has that name
"""

from typing import Final

from truepose.domain.errors import TrueposeError

_LONGEST: Final = 600  # characters: more than any sentence of ours has by itself


class ExchangeError(TrueposeError):
    """Base of every error of this package."""


class InputFileError(ExchangeError):
    """A file or table given by the user cannot be used.

    Parameters
    ----------
    sentence : str
        What is wrong and what to do, without the place and without a full stop.
    file : str
        Name of the file as the user knows it.
    line : int, optional
        1-based line in it.
    row : int, optional
        0-based row of a table that is no file but arrays of a program.
    column : str, optional
        Name of the column of a table, or the 1-based place in a line of a program.
    key : str, optional
        Path of the key in a JSON or TOML document, such as ``dhm_nominal[2].a_mm`` (0-based).

    Examples
    --------
    >>> import truepose as tp
    >>> try:
    ...     tp.read_campaign({"config": [1]}, robot="abb-irb-120")
    ... except tp.InputFileError as error:
    ...     print(error, error.file)
    calibration: column q1_deg is missing; it is required. calibration
    """

    def __init__(
        self,
        sentence: str,
        *,
        file: str,
        line: int | None = None,
        row: int | None = None,
        column: str | None = None,
        key: str | None = None,
    ) -> None:
        sentence = _on_one_line(sentence)
        place = [_on_one_line(file)]
        if line is not None:
            place.append(f"line {line}")
        if row is not None:
            place.append(f"row {row}")
        if column is not None:
            place.append(f"column {_on_one_line(column)}")
        if key:
            place.append(f"key {_on_one_line(key)}")
        super().__init__(f"{', '.join(place)}: {sentence}.")
        self.sentence = sentence
        self.file = file
        self.line = line
        self.row = row
        self.column = column
        self.key = key


def _on_one_line(text: str) -> str:
    """Return words with what a stranger wrote among them, cut in their middle where he wrote a book."""
    line = "".join(letter if letter.isprintable() else " " for letter in text)
    # What to do about it stands at the end.
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"


class MissingFileError(InputFileError):
    """The file, or one that it names, is not there."""


class UnreadableFileError(InputFileError):
    """The file is not what its name promises."""


class MissingEntryError(InputFileError):
    """A required column or key is absent."""


class WrongUnitError(InputFileError):
    """A column or key is there in another unit than the format's."""


class BadValueError(InputFileError):
    """A value cannot be meant: text for a number, not finite, out of its range, at odds with another."""


class NewerVersionError(InputFileError):
    """The file was written by a later program and may say what this one does not know."""


class EditedFileError(InputFileError):
    """The file carries the digest of other values: somebody edited it after truepose wrote it."""


class ImplausibleModelError(InputFileError):
    """The model moves the tool further, or has values further from their priors, than is accepted."""


class UnsafeArchiveError(InputFileError):
    """The archive has members outside itself, or of a size that no campaign has."""


class UnknownRobotError(ExchangeError):
    """No shipped robot has that name."""
