"""The campaigns of an archive, wherever it lies: folders and zips in a folder, or a database."""

import asyncio
import contextlib
import functools
import hashlib
import io
import zipfile
from collections.abc import Callable, Coroutine, Iterator
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Final, TypeVar

from truepose.analysis.archive.outcome import Found
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.folder import DESCRIPTION
from truepose.exchange.input_file import read_bytes
from truepose.exchange.tables.visits import NOT_STATED, Stated
from truepose.storage.backup.transfer import snapshot
from truepose.storage.calibration.campaigns import CampaignRepository
from truepose.storage.calibration.diagnoses import DiagnosisRepository
from truepose.storage.calibration.results import ResultRepository
from truepose.storage.connection.address import shown_address
from truepose.storage.database import Database
from truepose.storage.plant.campaigns import CollectedCampaigns
from truepose.storage.records import CampaignRecord, DiagnosisRecord, IdentificationRecord, Page

T = TypeVar("T")
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)  # the same files give the same bytes
_PAGE: Final = 500


@dataclass(frozen=True, slots=True)
class Archived:
    """A campaign of an archive; its data are read when they are needed."""

    name: str
    load: Callable[[], bytes]  # as the storage keeps it, or the zip of its folder
    before: Callable[[], Found | None]  # what is stored of it
    stated: Stated = NOT_STATED  # what is on record beside it


def sha256(data: bytes) -> str:
    """Return what tells data from others."""
    return hashlib.sha256(data).hexdigest()


def in_folder(folder: Path) -> list[Archived]:
    """Return the campaigns in a folder: its folders with a description and its zips, by name.

    Raises
    ------
    ConfigurationError
        There is none.
    """
    found = [
        Archived(path.name, functools.partial(_content, path), _nothing)
        for path in sorted(folder.iterdir())
        if path.suffix.lower() == ".zip" or (path / DESCRIPTION).is_file()
    ]
    if not found:
        raise ConfigurationError(
            f"{folder} holds no campaign: give a folder of campaign folders (each with {DESCRIPTION}) or of "
            "zips, or a database."
        )
    return found


def _nothing() -> None:
    return None


def _content(path: Path) -> bytes:
    if path.is_file():
        return read_bytes(path)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for file in sorted(path.rglob("*")):
            if file.is_file():
                inside = zipfile.ZipInfo(file.relative_to(path).as_posix(), _EPOCH)
                archive.writestr(inside, read_bytes(file))
    return packed.getvalue()


@contextlib.contextmanager
def in_database(url: str) -> Iterator[list[Archived]]:
    """Offer the campaigns of a database as it is at this moment, with the newest that is stored of each.

    They are read from a copy: the database stays as it is, and a service may have it open.

    Raises
    ------
    StorageError
        There is no such database, or it cannot be read.
    ConfigurationError
        It holds no campaign.
    """
    with (
        snapshot(url) as copy,
        contextlib.closing(Database(copy)) as database,
        asyncio.Runner() as runner,
    ):
        found = [*_own(database, runner), *_collected(database, runner)]
        if not found:
            raise ConfigurationError(f"{shown_address(url)} holds no campaign.")
        yield found


def _own(database: Database, runner: asyncio.Runner) -> Iterator[Archived]:
    """Yield what was measured or uploaded here."""
    campaigns, stored = CampaignRepository(database), _Stored(database, runner)
    for record in _all(runner, campaigns):
        serial, day = runner.run(campaigns.measured(record.id))
        yield Archived(
            f"{record.id} {record.name}",
            functools.partial(_run, runner, campaigns.content, record.id),
            functools.partial(stored.newest, record),
            _stated(serial, record.summary.instrument_serial_number or "", day),
        )


def _collected(database: Database, runner: asyncio.Runner) -> Iterator[Archived]:
    """Yield what a plant has collected from its cells."""
    collected = CollectedCampaigns(database)
    for seen in runner.run(collected.all()):
        yield Archived(
            f"{seen.cell} {seen.record_id} {seen.name}",
            functools.partial(_run, runner, collected.content, seen),
            _nothing,
            _stated(seen.robot_serial_number, seen.instrument_serial_number, seen.measured_on),
        )


def _run(runner: asyncio.Runner, content: Callable[[T], Coroutine[None, None, bytes]], of: T) -> bytes:
    """Return the data of a campaign that a database has."""
    return runner.run(content(of))


def _stated(robot: str, instrument: str, day: str) -> Stated:
    return Stated(robot, instrument, date.fromisoformat(day) if day else None)


def _all(runner: asyncio.Runner, campaigns: CampaignRepository) -> Iterator[CampaignRecord]:
    after: int | None = 0
    while after is not None:
        part = runner.run(campaigns.page(Page(after, _PAGE)))
        yield from part
        after = part.next_after


class _Stored:
    """What a database says of its campaigns."""

    def __init__(self, database: Database, runner: asyncio.Runner) -> None:
        self._results, self._diagnoses = ResultRepository(database), DiagnosisRepository(database)
        self._runner = runner

    def newest(self, campaign: CampaignRecord) -> Found | None:
        """Return the latest identification of a campaign with its latest diagnosis; None without either."""
        identified = self._runner.run(self._results.newest_identification_of(campaign.id))
        diagnosed = self._runner.run(self._diagnoses.newest_of_campaign(campaign.id))
        if identified is None and diagnosed is None:
            return None
        return _found(campaign.robot, identified, diagnosed)


def _found(robot: str, identified: IdentificationRecord | None, diagnosed: DiagnosisRecord | None) -> Found:
    from truepose.exchange.results.diagnosis import diagnosis_document
    from truepose.exchange.results.identification import identification_document

    return Found(
        None if identified is None else identification_document(identified.identification, robot),
        None if diagnosed is None else diagnosis_document(diagnosed.diagnosis),
    )
