"""What earlier nights measured: a line of JSON a night, and what tonight is against them."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from pydantic import AwareDatetime, BaseModel, ValidationError

from truepose.night.errors import UnreadableHistoryError

HISTORY: Final = "history.jsonl"
COMPARED_NIGHTS: Final = 30
_ENOUGH: Final = 5  # nights by which a usual spread is known at all
# Four robust standard deviations: one figure in 16,000 by chance, of a hundred a night one in half a year.
_FAR: Final = 4.0
_MAD_TO_SIGMA: Final = 1.4826  # of a normal distribution
# Nights of the same program repeat a figure to the last digit; a spread of nothing would cry at rounding.
_LEAST_SHARE: Final = 0.05


class NightFigure(BaseModel, frozen=True):
    """A figure of one night."""

    case: str
    figure: str
    passed: bool
    value: float | None


class Night(BaseModel, frozen=True):
    """What one night measured."""

    began: AwareDatetime
    version: str
    label: str  # of whoever ran it, e.g. a commit; may be empty
    seed: int
    figures: tuple[NightFigure, ...]

    @property
    def name(self) -> str:
        """How it is called where it has to be found again."""
        mark = f", {self.label}" if self.label else ""
        return f"{self.began.date().isoformat()} (truepose {self.version}{mark})"

    def measured(self, case: str, figure: str) -> NightFigure | None:
        """Return one figure; None where the night did not have it."""
        return self._by_name.get((case, figure))

    @cached_property
    def _by_name(self) -> dict[tuple[str, str], NightFigure]:
        return {(one.case, one.figure): one for one in self.figures}


@dataclass(frozen=True, slots=True)
class FigureHistory:
    """A figure through the nights, the oldest first, tonight last; None where a night did not have it."""

    nights: tuple[Night, ...]
    measured: tuple[NightFigure | None, ...]

    @property
    def first_bad(self) -> Night | None:
        """The first of the nights in a row that missed it, tonight among them; None where tonight did not."""
        found = None
        for night, one in zip(reversed(self.nights), reversed(self.measured), strict=True):
            if one is None:
                continue
            if one.passed:
                break
            found = night
        return found

    @property
    def usual(self) -> tuple[float, float] | None:
        """Median of the nights before, and how far from it is no longer usual; None of too few."""
        before = [one.value for one in self.measured[:-1] if one is not None and one.value is not None]
        if len(before) < _ENOUGH:
            return None
        median = float(np.median(before))
        spread = _MAD_TO_SIGMA * float(np.median(np.abs(np.array(before) - median)))
        return median, max(_FAR * spread, _LEAST_SHARE * abs(median))

    @property
    def unusual(self) -> bool:
        """Whether tonight is far from what the nights before were."""
        tonight, usual = self.measured[-1], self.usual
        if tonight is None or tonight.value is None or usual is None:
            return False
        median, far = usual
        return abs(tonight.value - median) > far


def course(nights: Sequence[Night], case: str, figure: str) -> FigureHistory:
    """Return a figure through the nights that are compared."""
    compared = tuple(nights[-COMPARED_NIGHTS - 1 :])
    return FigureHistory(compared, tuple(night.measured(case, figure) for night in compared))


def read_history(file: Path) -> list[Night]:
    """Return the nights of a file, the oldest first; none where there is no file yet.

    Raises
    ------
    UnreadableHistoryError
        A line is no night. A last line without its end is a night whose machine stopped: it is left out.
    """
    if not file.exists():
        return []
    *whole, _ = file.read_text(encoding="utf-8").split("\n")
    return list(_nights(whole, file))


def _nights(lines: Sequence[str], file: Path) -> Iterator[Night]:
    for number, line in enumerate(lines, start=1):
        try:
            yield Night.model_validate_json(line)
        except ValidationError as error:
            raise UnreadableHistoryError(
                f"{file}, line {number}: this is not the record of a nightly run. Move the file away to "
                "start a new one."
            ) from error


def append_night(file: Path, night: Night) -> None:
    """Write a night to the end of the file, and to the disk; raises OSError."""
    torn = _torn(file)
    with file.open("ab") as lines:
        lines.truncate(lines.tell() - torn)
        lines.write(night.model_dump_json().encode() + b"\n")
        lines.flush()
        os.fsync(lines.fileno())


def _torn(file: Path) -> int:
    """Return how many bytes at the end belong to a line that was never finished."""
    content = file.read_bytes() if file.exists() else b""
    return len(content) - (content.rfind(b"\n") + 1)
