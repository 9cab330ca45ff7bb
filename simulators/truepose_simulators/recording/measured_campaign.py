"""A measured campaign as far as a replay needs it: its description and its tables."""

import csv
import io
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from truepose_simulators.errors import ReplayError
from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.table import convert, read_text


@dataclass(frozen=True, slots=True)
class MeasuredTable:
    """Columns of text, in the order of the file."""

    name: str
    columns: Mapping[str, Sequence[str]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __contains__(self, column: str) -> bool:
        return column in self.columns

    def numbers(self, column: str) -> FloatArray:
        """Numbers of a column, shape (n,), NaN where a cell is empty; raises ReplayError."""
        if column not in self.columns:
            raise ReplayError(f"{self.name} has no column {column}, which a replay needs")
        cells = self.columns[column]
        return np.array([self._number(text, column, line) for line, text in enumerate(cells, start=2)])

    def known(self, column: str) -> FloatArray:
        """Numbers of a column without empty cells, shape (n,); raises ReplayError."""
        values = self.numbers(column)
        if np.isnan(values).any():
            line = 2 + int(np.argmax(np.isnan(values)))
            raise ReplayError(f"{self.name}, line {line}: {column} is empty, which a replay needs")
        return values

    def or_else(self, column: str, default: float) -> FloatArray:
        """Numbers of a column that may be absent, `default` where nothing stands; shape (n,)."""
        values = self.numbers(column) if column in self else np.full(len(self), math.nan)
        return np.where(np.isnan(values), default, values)

    def per_joint(self, form: str, n_joints: int) -> FloatArray:
        """Columns such as q1_deg.. of `form` "q{}_deg", shape (n, J); raises ReplayError for another J."""
        pattern = re.escape(form).replace(r"\{\}", "([0-9]+)")
        found = sum(re.fullmatch(pattern, column) is not None for column in self.columns)
        if found != n_joints:
            raise ReplayError(
                f"{self.name} has {found} columns {form.format('<joint>')}, the robot of the model has"
                f" {n_joints} joints"
            )
        return np.stack([self.known(form.format(joint)) for joint in range(1, n_joints + 1)], axis=1)

    def with_positions(self, position_mm: FloatArray, left_out: Sequence[str]) -> "MeasuredTable":
        """Return the table with other positions (n, 3) and without some columns."""
        kept = {name: cells for name, cells in self.columns.items() if name not in left_out}
        read = {f"{axis}_mm": [f"{value:.5f}" for value in position_mm[:, i]] for i, axis in enumerate("xyz")}
        return MeasuredTable(self.name, {**kept, **read})

    def _number(self, text: str, column: str, line: int) -> float:
        if not text.strip():
            return math.nan
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ReplayError(f'{self.name}, line {line}: {column} must be a finite number, not "{text}"')
        return value


def read_table(path: Path) -> MeasuredTable:
    """Read a table; raises ReplayError with file and line."""
    try:
        rows = [row for row in csv.reader(io.StringIO(read_text(path), newline="")) if row]
    except OSError as error:
        raise ReplayError(f"{path} cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ReplayError(f"{path.name} is not a CSV table in UTF-8: {error}") from error
    if len(rows) < 2:
        raise ReplayError(f"{path.name} has no rows: there is nothing to replay")
    header = [name.strip() for name in rows[0]]
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(header):
            raise ReplayError(f"{path.name}, line {line}: {len(row)} cells, but the header has {len(header)}")
    return MeasuredTable(path.name, dict(zip(header, zip(*rows[1:], strict=True), strict=True)))


POINTS = ("calibration", "validation")
REFERENCE = "reference"
_NAME = "campaign.json"


def read_description(folder: Path) -> dict[str, Any]:
    """Read campaign.json of a folder; raises ReplayError."""
    path = folder / _NAME
    try:
        document = json.loads(read_text(path))
    except OSError as error:
        raise ReplayError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise ReplayError(f"{path} is not JSON: {error}") from error
    if not isinstance(document, dict):
        raise ReplayError(f"{path} must be a table of keys")
    return document


def tracker_files(document: Mapping[str, Any]) -> dict[str, str]:
    """Names of the tables by role; raises ReplayError for what no tracker reads."""
    files = document.get("files")
    if not isinstance(files, dict) or not files:
        raise ReplayError(f'{_NAME}: key "files" must name the tables of the campaign')
    for role, name in files.items():
        if role not in {*POINTS, REFERENCE}:
            raise ReplayError(
                f'{_NAME}: "{role}" of key "files" cannot be replayed: only a laser tracker is simulated here'
            )
        # Of the campaign's own folder: a description that came from elsewhere names no other file.
        if not isinstance(name, str) or not re.fullmatch(r"[^/\\]+\.csv", name):
            raise ReplayError(f'{_NAME}: "{role}" of key "files" must name a CSV file of the folder')
    return files


def certified_nests_mm(document: Mapping[str, Any]) -> FloatArray:
    """Certified places of the fixed nests, shape (k, 3), of none where the campaign states none."""
    stated = document.get("fixed_nests_certified_mm")
    nests = () if stated is None else convert(tuple[Vector, ...], stated, f"{_NAME}: the fixed nests")
    return np.array(nests, dtype=np.float64).reshape(-1, 3)
