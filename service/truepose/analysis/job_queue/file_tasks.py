"""Files that somebody sends, in the worker: campaigns read and understood, targets read and corrected.

As in `tasks`, what computes is imported where it is needed.
"""

import hashlib
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from truepose.domain.correction import CorrectedTargets, FileCorrection
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model
from truepose.exchange.programs.correction_request import CorrectionRequest
from truepose.messages.message import Text, message
from truepose.storage.documents import pack
from truepose.storage.records import CampaignSummary

if TYPE_CHECKING:
    from truepose.exchange.corrections import Rows
    from truepose.exchange.import_wizard.dialogue import Choices, Understood


_BESIDE: Final = "brought"  # in the archive of a campaign: the files as they came
_DESCRIPTION: Final = "campaign.json"
Report: TypeAlias = Callable[[float, Text], None]


@dataclass(frozen=True, slots=True)
class CampaignRead:
    """A campaign of files that somebody brought, to be stored."""

    robot: str
    summary: CampaignSummary
    campaign: bytes
    archive: bytes = b""  # made of the files; empty: they came as one


@dataclass(frozen=True, slots=True)
class BroughtRead:
    """What was understood of them, and the campaign that was asked for, if it can be made."""

    understood: "Understood"
    campaign: CampaignRead | None = None


@dataclass(frozen=True, slots=True)
class ReadBroughtTask:
    """Read files that somebody brought, as far as it goes."""

    files: tuple[tuple[str, str], ...]  # name and where it lies
    choices: "Choices"
    make: bool = False  # a campaign, not only what is shown

    def perform(self, report: Report) -> BroughtRead:
        """Return what was understood; raises TrueposeError."""
        from truepose.analysis.campaigns.tracker import summary_of
        from truepose.exchange.campaigns.zip_file import write_campaign_zip
        from truepose.exchange.import_wizard.reading import read_imported_files

        files = {name: Path(path).read_bytes() for name, path in self.files}
        found = read_imported_files(files, self.choices)
        if not self.make or found.campaign is None:
            return BroughtRead(found.understood)
        beside = {f"{_BESIDE}/{_safe(name)}": data for name, data in files.items()}
        made = CampaignRead(
            found.campaign.robot.name,
            summary_of(found.campaign),
            pack(found.campaign),
            write_campaign_zip(found.campaign, beside),
        )
        return BroughtRead(found.understood, made)


def _safe(path: str) -> str:
    """Return a path that stays in the archive; no second description, since an archive has one."""
    # Names come from whoever brought the files. A member that leads out of the archive would make it one that
    # this program itself refuses to read.
    parts = [part for part in path.replace("\\", "/").split("/") if part not in {"", ".", ".."}]
    parts = [part.replace(":", "_") for part in parts] or ["file"]
    # Two descriptions are two campaigns to whoever reads the archive.
    parts[-1] = f"as-it-came-{parts[-1]}" if parts[-1] == _DESCRIPTION else parts[-1]
    return "/".join(parts)


MOST_TARGETS: Final = 100_000  # their answer is some 25 MB, which is stored before a reading would notice
MOST_LEFT_ALONE: Final = 500  # that a record tells one by one; lists hold many records


@dataclass(frozen=True, slots=True)
class TargetsFile:
    """A file that somebody sent, how it is meant, and the model that corrects it."""

    model: Model
    name: str
    data: bytes
    asked: CorrectionRequest


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
        from truepose.exchange.corrections import check_file

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
        from truepose.exchange.corrections import correct_file
        from truepose.messages.catalogue import english

        report(0.0, message("job.doing.reading_file", file=self.file.name))
        file, out, rows = self.file, io.BytesIO(), []

        def seen(some: "Rows") -> None:
            rows.append(_columns(file.model, some))
            report(some.share, message("job.doing.targets", targets=sum(len(part.names) for part in rows)))

        answer = correct_file(file.model, file.name, file.data, file.asked, out, seen)
        # A table is written row by row, before all of it is known; what must not be used ends here and is
        # never stored.
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

    from truepose.correction import pose_shifts

    found = rows.found
    place, shift = pose_shifts(model, rows.goals, found.joints_rad)
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
    # Targets that were not solved have no shift, and the largest of none is not 0.
    known = shift[np.isfinite(shift)]
    return float(known.max()) if len(known) else float("nan")


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
