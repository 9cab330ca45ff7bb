"""An archive of campaigns, a folder or a database, and all of it computed anew, whatever interrupts that.

Each campaign is computed once for its data and this version.
"""

import asyncio
import contextlib
import functools
import hashlib
import io
import zipfile
from collections.abc import Callable, Coroutine, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Final, TypeVar

from truepose.analysis.archive_outcomes import (
    ArchiveOutcome,
    Change,
    Key,
    Results,
    ToAnalyse,
    analyse,
    change,
)
from truepose.analysis.parallel.arithmetic import program
from truepose.analysis.parallel.tasks import Cluster, Part, PartFailure
from truepose.domain.diagnosis import Diagnosis
from truepose.domain.errors import ConfigurationError, TrueposeError
from truepose.domain.identification import Identification
from truepose.exchange.campaigns.folder import DESCRIPTION
from truepose.exchange.document import read_bytes
from truepose.exchange.tables.files import NOT_STATED, Stated
from truepose.messages.message import Text
from truepose.storage.backup.transfer import snapshot
from truepose.storage.database import Database
from truepose.storage.engine.address import display_address
from truepose.storage.plant.overview import CollectedCampaigns
from truepose.storage.records import CampaignRecord, Page
from truepose.storage.results.campaigns import CampaignRepository
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.models import ResultRepository

T = TypeVar("T")
Found = TypeVar("Found", Identification, Diagnosis)
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)  # the same files give the same bytes
_PAGE: Final = 500


@dataclass(frozen=True, slots=True)
class ArchivedCampaign:
    """A campaign of an archive; its data are read when they are needed."""

    name: str
    load: Callable[[], bytes]  # as the storage keeps it, or the zip of its folder
    before: Callable[[], ArchiveOutcome | None]  # what is stored of it
    stated: Stated = NOT_STATED  # what is on record beside it


def sha256(data: bytes) -> str:
    """Return what tells data from others."""
    return hashlib.sha256(data).hexdigest()


def in_folder(folder: Path) -> list[ArchivedCampaign]:
    """Return the campaigns in a folder: its folders with a description and its zips, by name.

    Raises
    ------
    ConfigurationError
        There is none.
    """
    found = [
        ArchivedCampaign(path.name, functools.partial(_content, path), _nothing)
        for path in sorted(folder.iterdir())
        if path.suffix.lower() == ".zip" or (path / DESCRIPTION).is_file()
    ]
    if not found:
        raise ConfigurationError(
            f"No campaign found in {folder}. Give a folder of campaign folders (each with {DESCRIPTION}) or "
            "zip files, or a database."
        )
    return found


def _nothing() -> None:
    return None


def _content(path: Path) -> bytes:
    if path.is_file():
        return read_bytes(path)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        # One order and one date: a result is found again by the hash of these bytes, so the same files must
        # give the same.
        for file in sorted(path.rglob("*")):
            if file.is_file():
                inside = zipfile.ZipInfo(file.relative_to(path).as_posix(), _EPOCH)
                archive.writestr(inside, read_bytes(file))
    return packed.getvalue()


@contextlib.contextmanager
def in_database(url: str) -> Iterator[list[ArchivedCampaign]]:
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
        # From one snapshot: a service may add campaigns meanwhile, which the next run finds.
        found = [*_own(database, runner), *_collected(database, runner)]
        if not found:
            raise ConfigurationError(f"No campaign found in the database {display_address(url)}.")
        yield found


def _own(database: Database, runner: asyncio.Runner) -> Iterator[ArchivedCampaign]:
    """Yield what was measured or uploaded here."""
    campaigns = CampaignRepository(database)
    for record in _all(runner, campaigns):
        serial, day = runner.run(campaigns.measured(record.id))
        yield ArchivedCampaign(
            f"{record.id} {record.name}",
            functools.partial(_run, runner, campaigns.content, record.id),
            functools.partial(_stored_outcome, database, runner, record),
            _stated(serial, record.summary.instrument_serial_number or "", day),
        )


def _collected(database: Database, runner: asyncio.Runner) -> Iterator[ArchivedCampaign]:
    """Yield what a plant has collected from its cells."""
    collected = CollectedCampaigns(database)
    for seen in runner.run(collected.all()):
        yield ArchivedCampaign(
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


def _stored_outcome(
    database: Database, runner: asyncio.Runner, campaign: CampaignRecord
) -> ArchiveOutcome | None:
    """Return the latest identification of a campaign with its latest diagnosis; None without either."""
    from truepose.exchange.results.diagnosis import diagnosis_document
    from truepose.exchange.results.identification import identification_document

    identified = runner.run(ResultRepository(database).newest_identification_of(campaign.id))
    diagnosed = runner.run(DiagnosisRepository(database).newest_of_campaign(campaign.id))
    identification = None if identified is None else _of_all_readings(identified.identification)
    diagnosis = None if diagnosed is None else _of_all_readings(diagnosed.diagnosis)
    if identification is None and diagnosis is None:
        return None
    return ArchiveOutcome(
        None if identification is None else identification_document(identification, campaign.robot),
        None if diagnosis is None else diagnosis_document(diagnosis),
    )


def _of_all_readings(found: Found) -> Found | None:
    """Return a result unless some readings were set aside: computed anew it differs for that alone."""
    return found if found.set_aside is None else None


Told = Callable[[float, Text], None]
_RESULTS: Final = "results"


@dataclass(frozen=True, slots=True)
class ReanalysisResult:
    """What came of an archive."""

    changes: tuple[Change, ...]  # in the order of the archive
    computed: int
    there_already: int

    @property
    def failed(self) -> tuple[Change, ...]:
        """Campaigns without a result, each with its reason."""
        return tuple(row for row in self.changes if row.failed)


class Archive:
    """Campaigns, and the folder in which their results are kept."""

    def __init__(
        self,
        campaigns: Sequence[ArchivedCampaign],
        out: Path,
        effects: tuple[str, ...] | None = None,
        against: Path | None = None,
    ) -> None:
        self._campaigns = campaigns
        self._effects = effects
        self._results = Results(_folder(out))
        self._earlier = self._results if against is None else Results(_results_of(against))
        self._keys: dict[int, Key] = {}  # by the place of the campaign in the archive
        self._failed: dict[int, str] = {}
        self._asked: list[int] = []  # places of the parts that were sent

    def compute(self, cluster: Cluster, told: Told) -> ReanalysisResult:
        """Compute what is not there yet, and compare all of it with what was found before.

        A result is on disk before the next one is waited for. Raises ClusterError where workers are lost for
        good: what is on disk stays, and the next run goes on from there.
        """
        computed = 0
        for outcome in cluster.outcomes(analyse, self._missing()):
            # Parts are numbered as they were sent, and campaigns that are there already were not.
            place = self._asked[outcome.number]
            if isinstance(outcome, PartFailure):
                self._failed[place] = outcome.why
            else:
                self._results.keep(self._keys[place], outcome.answer)
                computed += 1
            told(len(self._keys) / len(self._campaigns), outcome.name)
        there = len(self._keys) - computed - len(self._failed)
        return ReanalysisResult(tuple(self._changes()), computed, there)

    def _missing(self) -> Iterator[Part[ToAnalyse]]:
        for place, campaign in enumerate(self._campaigns):
            try:
                content = campaign.load()
            # A campaign that cannot be read is told at the end; a night's work on the others does not stop at
            # it.
            except TrueposeError as error:
                self._failed[place] = str(error)
                content = b""
            key = Key(campaign.name, sha256(content), program(), self._effects)
            self._keys[place] = key
            if place not in self._failed and not self._results.has(key):
                self._asked.append(place)
                yield Part(campaign.name, ToAnalyse(key, content))

    def _changes(self) -> Iterator[Change]:
        for place, campaign in enumerate(self._campaigns):
            key = self._keys[place]
            now = self._results.get(key)
            if now is None:
                yield Change(campaign.name, failed=self._failed[place])
            else:
                yield change(campaign.name, self._before(key, campaign), now)

    def _before(self, key: Key, campaign: ArchivedCampaign) -> ArchiveOutcome | None:
        return self._earlier.of_another_program(key) or campaign.before()


def _folder(out: Path) -> Path:
    folder = out / _RESULTS
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _results_of(out: Path) -> Path:
    folder = out / _RESULTS
    if not folder.is_dir():
        raise ConfigurationError(
            f"No results of an earlier run found in {out}. Give the folder that --out named in that run."
        )
    return folder
