"""What is found of a campaign of an archive, kept as a file, and what differs from an earlier version."""

import functools
import hashlib
import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from truepose.exchange.json_text import render_json

Document: TypeAlias = Mapping[str, Any]
_FORMAT: Final = "truepose archive result 1"
_UNSAFE: Final = re.compile(r"[^\w.-]+")
_SHORT: Final = 12  # characters of a hash that a file name shows


@dataclass(frozen=True, slots=True)
class ArchiveOutcome:
    """What was found, as the documents that `identify --json` and `diagnose --json` print."""

    identification: Document | None
    diagnosis: Document | None
    bits_sha256: str = ""  # of the results as they stand in memory; empty where nobody noted it


@dataclass(frozen=True, slots=True)
class Key:
    """What a result is of; where all of it is the same, it is not computed again."""

    campaign: str
    data_sha256: str
    program: str
    effects: tuple[str, ...] | None

    @property
    def file_name(self) -> str:
        """Return the name of the file that has the result."""
        told = json.dumps([self.campaign, self.data_sha256, self.program, self.effects])
        return f"{_plain(self.campaign)}.{hashlib.sha256(told.encode()).hexdigest()[:_SHORT]}.json"


@dataclass(frozen=True, slots=True)
class ToAnalyse:
    """A campaign as it travels to a worker."""

    key: Key
    content: bytes  # as the storage keeps it, or the zip of its folder


def analyse(asked: ToAnalyse, _seed: np.random.SeedSequence) -> str:
    """Identify and diagnose a campaign and return the text of its file; nothing of it is drawn by chance.

    The text is made where the result is, as making it takes longer than sending it. Curves and single errors
    are left out, which are most of a diagnosis and which `diagnose` draws again. Raises TrueposeError.
    """
    from truepose.analysis.job_queue.tasks import stored_campaign
    from truepose.diagnosis.diagnose import diagnose
    from truepose.exchange.results.diagnosis import diagnosis_document
    from truepose.exchange.results.identification import identification_document
    from truepose.identification import identify
    from truepose.storage.documents import pack
    from truepose.storage.results.diagnoses import without_drawings

    key, campaign = asked.key, stored_campaign(asked.content)
    identified, diagnosed = identify(campaign, key.effects), diagnose(campaign, key.effects)
    # What the result answers stands in the file itself: its name has only the beginning of a hash.
    return render_json({
        "format": _FORMAT,
        "campaign": key.campaign,
        "data_sha256": key.data_sha256,
        "program": key.program,
        "effects": None if key.effects is None else list(key.effects),
        "bits_sha256": hashlib.sha256(pack(identified) + pack(diagnosed)).hexdigest(),
        "identification": identification_document(identified, campaign.robot.name),
        "diagnosis": diagnosis_document(without_drawings(diagnosed)),
    })


class Results:
    """A folder of results, one file each; a file is there whole or not at all."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def has(self, key: Key) -> bool:
        """Whether a result is there."""
        return _read(self._folder / key.file_name) is not None

    def get(self, key: Key) -> ArchiveOutcome | None:
        """Return a result, None where there is none."""
        document = _read(self._folder / key.file_name)
        return None if document is None else _of_document(document)

    def keep(self, key: Key, text: str) -> None:
        """Keep the text of a result; once this returns it is on disk."""
        keep_whole(self._folder / key.file_name, f"{text}\n".encode())

    @functools.cached_property
    def _by_name(self) -> dict[str, list[Path]]:
        """Files by what their names say of the campaign, as they were when somebody first asked."""
        found: dict[str, list[Path]] = {}
        for file in self._folder.glob("*.*.json"):
            found.setdefault(file.name.rsplit(".", 2)[0], []).append(file)
        return found

    def of_another_program(self, key: Key) -> ArchiveOutcome | None:
        """Return the newest result of the same data and effects by another version; None: there is none."""
        for file in sorted(self._by_name.get(_plain(key.campaign), ()), key=os.path.getmtime, reverse=True):
            document = _read(file)
            if document is None or document["program"] == key.program:
                continue
            if _asks(document) == _asks_of(key):
                return _of_document(document)
        return None


def _asks(document: Document) -> tuple[object, ...]:
    """Return what a result answers, whoever computed it."""
    return document["campaign"], document["data_sha256"], document["effects"]


def _asks_of(key: Key) -> tuple[object, ...]:
    return key.campaign, key.data_sha256, None if key.effects is None else list(key.effects)


def keep_whole(path: Path, data: bytes) -> None:
    """Write a file that is there whole or not at all; once this returns it is on disk."""
    # Under another name until it is whole: the next run takes each file that is there for work that is done,
    # and half of one would stay for ever (decision 0063).
    begun = path.with_suffix(".part")
    with begun.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    begun.replace(path)


def _plain(name: str) -> str:
    """Return a name as every file system takes it; what is lost of it is in the hash that follows."""
    return _UNSAFE.sub("-", name)[:60].strip(".-") or "campaign"


def _read(file: Path) -> Document | None:
    """Return the document of a result; None where the file is none: foreign, torn, or not there."""
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    ours = isinstance(document, dict) and document.get("format") == _FORMAT
    return document if ours else None


def _of_document(document: Document) -> ArchiveOutcome:
    return ArchiveOutcome(document["identification"], document["diagnosis"], document["bits_sha256"])


_SAME_MM = 1e-6  # of a mean error: what a new version of a library may do to the last digits
_SAME = 1e-3  # of a parameter, in its standard uncertainties
_JUDGED = ("validation", "cross_validation", "calibration")  # by what a model is judged, the best first


@dataclass(frozen=True, slots=True)
class Change:
    """A campaign before and now; empty or None where that was not found."""

    campaign: str
    status_before: str = ""
    status_now: str = ""
    mean_before_um: float | None = None  # error of the identified model on what judges it
    mean_now_um: float | None = None
    parameter: str = ""  # the one that changed most, against its standard uncertainty
    changed_by_u: float | None = None
    verdict_before: str = ""
    verdict_now: str = ""
    causes_gone: str = ""
    causes_new: str = ""
    failed: str = ""

    @property
    def compared(self) -> bool:
        """Whether there was a result before, and is one now."""
        return not self.failed and bool(self.status_before or self.verdict_before)

    @property
    def differs(self) -> bool:
        """Whether anything is other than it was."""
        if not self.compared:
            return False
        words = self.status_before != self.status_now or self.verdict_before != self.verdict_now
        means = _apart(self.mean_before_um, self.mean_now_um) > 1e3 * _SAME_MM
        moved = (self.changed_by_u or 0.0) > _SAME
        return bool(words or means or moved or self.causes_gone or self.causes_new)


def change(campaign: str, before: ArchiveOutcome | None, now: ArchiveOutcome) -> Change:
    """Return what is different; without anything before, what is there now."""
    parameter, by = _largest(before, now)
    causes_before, causes_now = _causes(before), _causes(now)
    diagnosed_twice = before is not None and before.diagnosis is not None
    return Change(
        campaign,
        status_before=_status(before),
        status_now=_status(now),
        mean_before_um=_mean_um(before),
        mean_now_um=_mean_um(now),
        parameter=parameter,
        changed_by_u=by,
        verdict_before=_verdict(before),
        verdict_now=_verdict(now),
        causes_gone=_listed(causes_before, causes_now),
        causes_new=_listed(causes_now, causes_before) if diagnosed_twice else "",
    )


def table(changes: Sequence[Change]) -> list[list[str]]:
    """Return the rows of a table with its head, one campaign a row."""
    head = [field.name for field in fields(Change)]
    return [head, *([_text(getattr(row, name)) for name in head] for row in changes)]


def _text(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def _apart(one: float | None, other: float | None) -> float:
    if one is None or other is None:
        return 0.0 if one == other else math.inf
    return abs(one - other)


def _status(found: ArchiveOutcome | None) -> str:
    return "" if found is None or found.identification is None else str(found.identification["status"])


def _verdict(found: ArchiveOutcome | None) -> str:
    return "" if found is None or found.diagnosis is None else str(found.diagnosis["verdict"])


def _mean_um(found: ArchiveOutcome | None) -> float | None:
    if found is None or found.identification is None:
        return None
    blocks: Document = found.identification["statistics"]
    for name in _JUDGED:
        if blocks.get(name):
            mean_mm = blocks[name]["identified"]["mean_mm"]
            return None if mean_mm is None else 1e3 * float(mean_mm)
    return None


def _causes(found: ArchiveOutcome | None) -> frozenset[str]:
    if found is None or found.diagnosis is None:
        return frozenset()
    return frozenset(f"{one['effect']} {one['subject']}" for one in found.diagnosis["findings"])


def _listed(causes: frozenset[str], others: frozenset[str]) -> str:
    return "; ".join(sorted(causes - others))


def _parameters(found: ArchiveOutcome | None) -> dict[str, Document]:
    if found is None or found.identification is None:
        return {}
    return {one["name"]: one for one in found.identification["parameters"]}


def _largest(before: ArchiveOutcome | None, now: ArchiveOutcome) -> tuple[str, float | None]:
    """Return the parameter that both have and that changed most, and by how many standard uncertainties."""
    earlier = _parameters(before)
    changed = [
        (abs(one["value"] - earlier[name]["value"]) / one["standard_uncertainty"], name)
        for name, one in _parameters(now).items()
        if name in earlier and one["standard_uncertainty"]
    ]
    by, name = max(changed, default=(None, ""))
    return name, by
