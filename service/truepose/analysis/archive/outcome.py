"""What is found of a campaign of an archive: computed on a worker, kept as a file, read back."""

import functools
import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from truepose.exchange.json_text import render_json

Document: TypeAlias = Mapping[str, Any]
_FORMAT: Final = "truepose archive result 1"
_UNSAFE: Final = re.compile(r"[^\w.-]+")
_SHORT: Final = 12  # characters of a hash that a file name shows


@dataclass(frozen=True, slots=True)
class Found:
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
    from truepose.analysis.workers.tasks import stored_campaign
    from truepose.diagnosis.diagnose import diagnose
    from truepose.exchange.results.diagnosis import diagnosis_document
    from truepose.exchange.results.identification import identification_document
    from truepose.identification import identify
    from truepose.storage.calibration.diagnoses import without_drawings
    from truepose.storage.columns import pack

    key, campaign = asked.key, stored_campaign(asked.content)
    identified, diagnosed = identify(campaign, key.effects), diagnose(campaign, key.effects)
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
        return (self._folder / key.file_name).is_file()

    def get(self, key: Key) -> Found | None:
        """Return a result, None where there is none."""
        return _read(self._folder / key.file_name) if self.has(key) else None

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

    def of_another_program(self, key: Key) -> Found | None:
        """Return the newest result of the same data and effects by another version; None: there is none."""
        for file in sorted(self._by_name.get(_plain(key.campaign), ()), key=os.path.getmtime, reverse=True):
            document = json.loads(file.read_text(encoding="utf-8"))
            if _asks(document) == _asks_of(key) and document["program"] != key.program:
                return _of_document(document)
        return None


def _asks(document: Document) -> tuple[object, ...]:
    """Return what a result answers, whoever computed it."""
    return document["campaign"], document["data_sha256"], document["effects"]


def _asks_of(key: Key) -> tuple[object, ...]:
    return key.campaign, key.data_sha256, None if key.effects is None else list(key.effects)


def keep_whole(path: Path, data: bytes) -> None:
    """Write a file that is there whole or not at all; once this returns it is on disk."""
    begun = path.with_suffix(".part")
    with begun.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    begun.replace(path)


def _plain(name: str) -> str:
    """Return a name as every file system takes it; what is lost of it is in the hash that follows."""
    return _UNSAFE.sub("-", name)[:60].strip(".-") or "campaign"


def _read(file: Path) -> Found:
    return _of_document(json.loads(file.read_text(encoding="utf-8")))


def _of_document(document: Document) -> Found:
    return Found(document["identification"], document["diagnosis"], document["bits_sha256"])
