"""One table where a command or a notebook wants rows, in the file format or as any program writes it.

A table in the format is read to the letter. Any other is read as files to be imported are: by its headings,
units, separators and decimal commas; what it was taken for is told.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from truepose.domain.contacts import Target
from truepose.exchange.document import read_bytes
from truepose.exchange.errors import InputFileError, MissingEntryError
from truepose.exchange.import_wizard.columns import ImportedTable
from truepose.exchange.import_wizard.dialogue import Choices, Understood
from truepose.exchange.import_wizard.display import files_seen, in_its_file
from truepose.exchange.import_wizard.files import pieces, unpack_files
from truepose.exchange.import_wizard.reading import SPREADS, detection_remarks
from truepose.exchange.import_wizard.tables import detected_tables, own_table
from truepose.exchange.tables.files import (
    PointsToPredict,
    ValidationFile,
    held_out_readings,
    points_to_predict,
)
from truepose.exchange.tables.table_reader import TableData, column_names
from truepose.messages.message import Message

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SingleTable:
    """A table by its name, as readers of the format take it, and what it was taken for."""

    name: str
    data: TableData
    remarks: tuple[Message, ...] = ()
    imported: ImportedTable | None = None  # None: it is in the format
    assumed: frozenset[str] = frozenset()  # columns that it does not have: its stops numbered, its only nest

    def validation(
        self, n_joints: int, nests: Collection[int], targets: Sequence[Target] = ()
    ) -> ValidationFile:
        """Return measured rows as `held_out_readings` reads them, and what columns were taken for.

        Raises InputFileError.
        """
        read = self._read(
            self.data, lambda name, data: held_out_readings(name, data, n_joints, nests, targets)
        )
        return replace(read, ignored=(*self.remarks, *read.ignored))

    def stops(self, n_joints: int, nests: Collection[int]) -> PointsToPredict:
        """Return stops as `points_to_predict` reads them, of every nest where it names none.

        Raises InputFileError.
        """
        read = self._read(
            self._of_every_nest(), lambda name, data: points_to_predict(name, data, n_joints, nests)
        )
        return replace(read, ignored=(*self.remarks, *read.ignored))

    def _read(self, data: TableData, reader: Callable[[str, TableData], T]) -> T:
        """Return what a reader makes of it; raises InputFileError at the line of the file."""
        try:
            return reader(self.name, data)
        except InputFileError as error:
            if self.imported is None:
                raise
            raise in_its_file(error, self.imported) from error

    def _of_every_nest(self) -> TableData:
        """Return the data without a nest that nobody named: whoever predicts wants all of them then."""
        if isinstance(self.data, bytes) or "nest" not in self.assumed:
            return self.data
        return {name: cells for name, cells in self.data.items() if name != "nest"}

    def with_uncertainty(self, u_mm: float | None) -> "SingleTable":
        """Return it with the standard uncertainty of each reading [mm]; what a column says goes first.

        Raises
        ------
        MissingEntryError
            No column says it, and nobody else did.
        """
        if isinstance(self.data, bytes) or any(name in self.data for name in SPREADS):
            return self
        if u_mm is None:
            raise MissingEntryError(
                "no column has the uncertainty of the readings; state it in mm (--u-mm, or a column u_mm)",
                file=self.name,
            )
        n = len(next(iter(self.data.values())))
        return replace(self, data={**self.data, "u_mm": np.full(n, u_mm)})


def single_table(name: str, data: bytes) -> SingleTable:
    """Return a table, understood as far as it goes; one without joints is left to the format's own reader.

    Raises
    ------
    InputFileError
        An archive or a workbook that no honest program writes, or a cell that nobody can have meant.
    """
    if _is_in_format(name, data):
        return SingleTable(name, data)
    found = pieces(unpack_files({name: data}), Choices())
    with_joints = [one for one in detected_tables(found, Choices()) if one.has("joint")]
    if not with_joints:
        return SingleTable(name, data)
    imported = own_table(with_joints[0])
    assumed = imported.columns.keys() - {one.column for one in with_joints[0].meanings}
    seen = Understood(files_seen(found, with_joints[:1]))
    return SingleTable(name, imported.columns, tuple(detection_remarks(seen)), imported, frozenset(assumed))


def _is_in_format(name: str, data: bytes) -> bool:
    try:
        return "q1_deg" in column_names(name, data)
    except InputFileError:
        return False


def read_validation_file(
    file: Path,
    n_joints: int,
    nests: Collection[int],
    targets: Sequence[Target] = (),
    u_mm: float | None = None,
) -> ValidationFile:
    """Read measured rows as `held_out_readings` does.

    Parameters
    ----------
    file : Path
    n_joints : int
    nests : collection of int
    targets : sequence of Target
        That the model knows.
    u_mm : float, optional
        Standard uncertainty of each reading, where no column says it [mm].

    Raises
    ------
    InputFileError
    """
    table = single_table(file.name, read_bytes(file)).with_uncertainty(u_mm)
    return table.validation(n_joints, nests, targets)


def read_points_to_predict(file: Path, n_joints: int, nests: Collection[int]) -> PointsToPredict:
    """Read stops as `points_to_predict` does; raises InputFileError."""
    return single_table(file.name, read_bytes(file)).stops(n_joints, nests)
