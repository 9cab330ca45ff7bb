"""Fleets of a plant: what each collected campaign tells, kept beside the database for who compares them."""

import asyncio
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Final

from truepose.analysis.errors import ClusterError
from truepose.analysis.page_services import Renderer
from truepose.analysis.parallel.addresses import Reach
from truepose.domain.errors import ConfigurationError
from truepose.storage.caches import DrawnFolder, rendered_page
from truepose.storage.plant.overview import CollectedCampaigns
from truepose.storage.plant.queries import ResultRecord
from truepose.version import program_sha256

if TYPE_CHECKING:
    from truepose.analysis.parallel.tasks import Outcome

_MOST_BYTES: Final = 1024 * 2**20  # some eight thousand campaigns
_TOGETHER: Final = 20  # campaigns that a worker process is asked for
_BY_MANY: Final = 200  # campaigns that many workers are asked for
_FRAME: Final = struct.Struct("<BQ")  # what follows, and its length


class _Answer(IntEnum):
    """What came of a campaign."""

    TOLD = 0
    FAILED = 1
    NOT_ASKED = 2  # the workers could not be used


@dataclass(frozen=True, slots=True)
class CollectedCampaign:
    """A campaign with what it tells, or why it tells nothing."""

    seen: ResultRecord
    told: bytes  # as `campaigns.summary_from` reads it; empty: nothing
    why: str = ""


@dataclass(frozen=True, slots=True)
class FleetRequest:
    """Campaigns as they travel to a worker process."""

    contents: tuple[bytes, ...]
    where: str | None  # workers that compute in its place


class CampaignSummaryService:
    """Has campaigns tell what they do, each once for this version of the program.

    Parameters
    ----------
    campaigns : CollectedCampaigns
    kept : DrawnFolder
        Of the answers.
    drawing : Renderer
        Has the worker process in which campaigns tell, or which asks other workers.
    where : str, optional
        As of `workers`; raises ConfigurationError where it names none.
    """

    def __init__(
        self,
        campaigns: CollectedCampaigns,
        kept: DrawnFolder,
        drawing: Renderer,
        where: str | None = None,
    ) -> None:
        self._campaigns = campaigns
        self._kept = kept
        self._drawing = drawing
        self._where = where
        self._reach = None if where is None else Reach(where)
        self._asking = asyncio.Lock()

    @staticmethod
    def folder(database: Path) -> DrawnFolder:
        """Return the folder in which answers are kept: it may be thrown away at any time."""
        return DrawnFolder(database.with_name(f"{database.name}.fleets"), _MOST_BYTES)

    async def campaigns(self) -> list[ResultRecord]:
        """Return all campaigns that were collected, in their order."""
        return await self._campaigns.all()

    async def away(self) -> str:
        """Return in a sentence why the workers of this plant cannot be asked, empty where they can."""
        return "" if self._reach is None else await self._reach.fault()

    async def known(self, campaigns: Sequence[ResultRecord]) -> tuple[CollectedCampaign, ...]:
        """Return what is kept of campaigns, without those that told nothing yet."""
        # The hash of all files of the program is read from disk the first time.
        program = await asyncio.to_thread(program_sha256)
        found = []
        for one in campaigns:
            kept = await asyncio.to_thread(self._kept.get, _of(program, one))
            if kept is not None:
                found.append(CollectedCampaign(one, kept.body))
        return tuple(found)

    async def told(self, campaigns: Sequence[ResultRecord]) -> tuple[CollectedCampaign, ...]:
        """Return what campaigns tell; who was not asked before is asked now, by workers or in a process.

        Raises ClusterError where the workers cannot be used; what was told until then is kept.
        """
        async with self._asking:  # who comes meanwhile finds what was told, and asks nobody twice
            known = {one.seen.id: one for one in await self.known(campaigns)}
            missing = [one for one in campaigns if one.id not in known]
            # In parts, each kept as it comes: where the workers are lost, the next visit goes on from there.
            together = _TOGETHER if self._where is None else _BY_MANY
            for first in range(0, len(missing), together):
                for found in await self._asked(missing[first : first + together]):
                    known[found.seen.id] = found
        return tuple(known[one.id] for one in campaigns)

    async def _asked(self, campaigns: Sequence[ResultRecord]) -> list[CollectedCampaign]:
        contents = tuple([await self._campaigns.content(one) for one in campaigns])
        answers = _unframed(await self._drawing.draw(summaries, FleetRequest(contents, self._where)))
        found, fault = [], ""
        for one, (answer, text) in zip(campaigns, answers, strict=True):
            if answer is _Answer.NOT_ASKED:
                fault = text.decode()
            elif answer is _Answer.FAILED:
                found.append(CollectedCampaign(one, b"", text.decode()))
            else:
                found.append(CollectedCampaign(one, text))
                await self._keep(found[-1])
        if self._reach is not None:
            self._reach.seen(fault)
        if fault:
            raise ClusterError(fault)
        return found

    async def _keep(self, found: CollectedCampaign) -> None:
        program = await asyncio.to_thread(program_sha256)
        await asyncio.to_thread(self._kept.keep, _of(program, found.seen), rendered_page(found.told))


def _of(program: str, campaign: ResultRecord) -> str:
    """Name a campaign by all that is known of it: a plant that is begun anew gives the same numbers again."""
    numbers = (campaign.branch_id, campaign.record_id)
    robot = (campaign.robot, campaign.robot_serial_number, campaign.instrument_serial_number)
    return f"{program}\n{(campaign.cell, *numbers, campaign.name, *robot, campaign.measured_on)}"


def summaries(asked: FleetRequest) -> bytes:
    """Return what stored campaigns tell, or why one does not, one frame each.

    In a worker process, where the numerics are imported, which takes longer than a campaign.
    """
    frames = _here(asked.contents) if asked.where is None else _by_workers(asked.contents, asked.where)
    return b"".join(_FRAME.pack(answer, len(text)) + text for answer, text in frames)


def _here(contents: Sequence[bytes]) -> Iterator[tuple[_Answer, bytes]]:
    from truepose.analysis.fleets.campaigns import tell
    from truepose.analysis.parallel.tasks import Task

    # As tasks, whose errors are answers: one bad campaign leaves the others theirs.
    for number, content in enumerate(contents):
        yield _answer_of(Task(tell, 0, number, content).perform().outcome(number, ""))


def _by_workers(contents: Sequence[bytes], where: str) -> list[tuple[_Answer, bytes]]:
    """Return what came until the workers were lost, if they were, and why the others were not asked."""
    from truepose.analysis.fleets.campaigns import tell
    from truepose.analysis.parallel.local_pool import workers
    from truepose.analysis.parallel.tasks import Part

    parts = [Part(f"campaign {number}", content) for number, content in enumerate(contents, start=1)]
    came, fault = {}, b""
    try:
        with workers(where, len(parts)) as cluster:
            for one in cluster.outcomes(tell, parts):
                came[one.number] = _answer_of(one)
    # No error of the answer: what came until then travels back and is kept.
    except (ClusterError, ConfigurationError) as error:
        fault = str(error).encode()
    return [came.get(number, (_Answer.NOT_ASKED, fault)) for number in range(len(parts))]


def _answer_of(one: "Outcome[bytes]") -> tuple[_Answer, bytes]:
    from truepose.analysis.parallel.tasks import PartFailure

    return (_Answer.FAILED, one.why.encode()) if isinstance(one, PartFailure) else (_Answer.TOLD, one.answer)


def _unframed(data: bytes) -> Iterator[tuple[_Answer, bytes]]:
    at = 0
    while at < len(data):
        answer, size = _FRAME.unpack_from(data, at)
        at += _FRAME.size + size
        yield _Answer(answer), data[at - size : at]
