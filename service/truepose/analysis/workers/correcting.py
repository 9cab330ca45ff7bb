"""Files of targets in the worker: read before anybody waits for them, then corrected.

As in `tasks`, what computes is imported where it is needed.
"""

import hashlib
import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

from truepose.domain.errors import ConfigurationError
from truepose.domain.results.corrections import CorrectedTargets, FileCorrection
from truepose.domain.results.identification import Model
from truepose.exchange.corrections.asked import Asked
from truepose.storage.columns import pack

if TYPE_CHECKING:
    from truepose.exchange.corrections.files import Rows

MOST_TARGETS: Final = 100_000  # their answer is some 25 MB, which is stored before a reading would notice
MOST_LEFT_ALONE: Final = 500  # that a record tells one by one; lists hold many records
Report: TypeAlias = Callable[[float, str], None]


@dataclass(frozen=True, slots=True)
class TargetsFile:
    """A file that somebody sent, how it is meant, and the model that corrects it."""

    model: Model
    name: str
    data: bytes
    asked: Asked


@dataclass(frozen=True, slots=True)
class FileChecked:
    """A file that can be read."""

    targets: int


@dataclass(frozen=True, slots=True)
class CheckFileTask:
    """Read a file of targets, and find that it is of such a robot."""

    file: TargetsFile

    def perform(self, report: Report) -> FileChecked:
        """Return how many targets it has; raises TrueposeError."""
        from truepose.exchange.corrections.files import check_file

        file = self.file
        return FileChecked(check_file(file.model, file.name, file.data, file.asked))


@dataclass(frozen=True, slots=True)
class FileCorrected:
    """A corrected file, to be stored."""

    correction: FileCorrection
    original_sha256: str
    corrected_sha256: str
    targets: bytes  # packed
    file: bytes


@dataclass(frozen=True, slots=True)
class CorrectFileTask:
    """Correct a file of targets."""

    file: TargetsFile

    def perform(self, report: Report) -> FileCorrected:
        """Return the file with other numbers, and what became of its targets; raises TrueposeError."""
        from truepose.exchange.corrections.files import correct_file
        from truepose.words.catalogue import english

        report(0.0, f"reading {self.file.name}")
        file, out, rows = self.file, io.BytesIO(), []

        def seen(some: "Rows") -> None:
            rows.append(_columns(file.model, some))
            report(some.share, f"{sum(len(part.names) for part in rows):,} targets")

        answer = correct_file(file.model, file.name, file.data, file.asked, out, seen)
        if answer.withheld:
            raise ConfigurationError(" ".join(map(english, (*answer.cautions[:1], answer.withheld))))
        targets = _joined(rows)
        correction = FileCorrection(
            answer.summary.totals,
            _largest(targets),
            answer.left_alone[:MOST_LEFT_ALONE],
            len(answer.left_alone),
            answer.cautions,
        )
        corrected = out.getvalue()
        return FileCorrected(correction, _sha256(file.data), _sha256(corrected), pack(targets), corrected)


def _columns(model: Model, rows: "Rows") -> CorrectedTargets:
    import numpy as np

    from truepose.correction import shifted_by

    found = rows.found
    sent = np.where(found.solved[:, None], found.joints_rad, np.nan)
    place, shift = shifted_by(model, rows.goals, sent)
    return CorrectedTargets(
        names=rows.names,
        statuses=tuple(map(str, found.status)),
        lines=rows.lines,
        place_mm=place,
        shift_mm=shift,
        uncertainty_mm=np.where(found.solved, found.uncertainty_mm, np.nan),
        outside_mm=found.outside_mm,
        moved_rad=np.where(found.solved, found.moved_rad, np.nan),
    )


def _joined(parts: list[CorrectedTargets]) -> CorrectedTargets:
    import numpy as np

    return CorrectedTargets(
        names=tuple(name for part in parts for name in part.names),
        statuses=tuple(status for part in parts for status in part.statuses),
        lines=np.concatenate([part.lines for part in parts]),
        place_mm=np.concatenate([part.place_mm for part in parts]),
        shift_mm=np.concatenate([part.shift_mm for part in parts]),
        uncertainty_mm=np.concatenate([part.uncertainty_mm for part in parts]),
        outside_mm=np.concatenate([part.outside_mm for part in parts]),
        moved_rad=np.concatenate([part.moved_rad for part in parts]),
    )


def _largest(targets: CorrectedTargets) -> float:
    import numpy as np

    shift = np.linalg.norm(targets.shift_mm, axis=1)
    known = shift[np.isfinite(shift)]
    return float(known.max()) if len(known) else float("nan")


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
