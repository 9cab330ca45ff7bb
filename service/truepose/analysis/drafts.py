"""Files and series that somebody brings: received, understood, and made a campaign with its jobs."""

import asyncio
import csv
import io
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, Final, ParamSpec, TypeVar

from truepose.analysis.errors import NotReadyError
from truepose.analysis.job_queue.file_tasks import BroughtRead, CampaignRead, ReadBroughtTask
from truepose.analysis.job_queue.supervisor import TaskRefusedError, Turns
from truepose.analysis.job_queue.uploads import Uploads
from truepose.analysis.jobs import JobService
from truepose.domain.campaign import Values
from truepose.exchange.import_wizard.dialogue import Fault, Understood, choices_of, merge_patch
from truepose.exchange.import_wizard.files import example_files
from truepose.exchange.tables.rows import written_text
from truepose.messages.catalogue import IN_ENGLISH
from truepose.messages.message import message
from truepose.storage.drafts import Draft, DraftFolder
from truepose.storage.ledger.series import SeriesRecord, SeriesRepository
from truepose.storage.records import Page, RequestKey
from truepose.storage.results.campaigns import CampaignRepository, NewCampaign

_REMEMBERED: Final = 20
_PATIENCE_S: Final = 60.0
_WHO: Final = ("measured_by", "instrument", "certificate", "measured_zone")
P = ParamSpec("P")
T = TypeVar("T")


class DraftService:
    """Takes what somebody brings to its diagnosis."""

    def __init__(
        self, drafts: DraftFolder, uploads: Uploads, campaigns: CampaignRepository, jobs: JobService
    ) -> None:
        self._drafts = drafts
        self._uploads = uploads
        self._campaigns = campaigns
        self._jobs = jobs
        self._turns = Turns(at_once=4, waiting=12, patience_s=_PATIENCE_S)
        self._seen: OrderedDict[tuple[int, int], Understood] = OrderedDict()
        self._making: dict[int, asyncio.Lock] = {}

    async def create(self) -> Draft:
        """Make an empty draft; raises ConflictError where too many are kept."""
        return await _off_the_loop(self._drafts.create)

    async def create_example(self) -> Draft:
        """Make a draft of the example; raises ConflictError where too many are kept."""
        draft = await self.create()
        for name, data in example_files().items():
            draft = await self.receive(draft.id, name, _whole(data))
        return draft

    async def all(self) -> tuple[Draft, ...]:
        """Return all drafts, the latest first."""
        return await _off_the_loop(self._drafts.all)

    async def get(self, number: int) -> Draft:
        """Return a draft; raises NotFoundError."""
        return await _off_the_loop(self._drafts.get, number)

    async def remove(self, number: int) -> None:
        """Throw a draft away; raises NotFoundError."""
        await _off_the_loop(self._drafts.remove, number)

    async def remove_file(self, number: int, file: int) -> Draft:
        """Take a file out of a draft; raises NotFoundError."""
        return await _off_the_loop(self._drafts.remove_file, number, file)

    async def receive(self, number: int, name: str, stream: AsyncIterator[bytes]) -> Draft:
        """Take a file in as it comes; it counts once it is whole. Raises NotFoundError, ConflictError."""
        async with self._turns.taken():
            with self._drafts.receiving(number) as incoming:
                async for data in stream:
                    await _off_the_loop(incoming.write, data)
                return await _off_the_loop(incoming.keep, name)

    async def say(self, number: int, said: Mapping[str, Any]) -> Draft:
        """Keep what somebody says of the files; raises NotFoundError."""
        draft = await self.get(number)
        return await _off_the_loop(self._drafts.keep_choices, number, merge_patch(draft.choices, said))

    async def understood(self, draft: Draft) -> Understood:
        """Return what is understood of a draft; raises BusyError."""
        # To understand a draft costs a worker process; a page that is looked at again costs none (decision
        # 0055).
        key = (draft.id, draft.revision)
        if key in self._seen:
            return self._seen[key]
        try:
            found = (await self._look(draft, make=False)).understood
        # What cannot be opened is shown on the page among the files, where it can be taken out again; an
        # error of the request would show nothing.
        except TaskRefusedError as error:
            found = Understood((), fault=Fault("", str(error)))
            # Without a code it is no word on the files: they took too long, or too much memory, this time.
            if not error.code:
                return found
        self._seen[key] = found
        while len(self._seen) > _REMEMBERED:
            self._seen.popitem(last=False)
        return found

    async def make(self, number: int, name: str | None) -> Draft:
        """Make a campaign of a draft, and queue its identification and its diagnosis; again, return the same.

        Raises
        ------
        NotFoundError, BusyError
        NotReadyError
            Something is asked still, or cannot be read; the sentence says what.
        """
        # Two clicks are one campaign: the second waits, and finds what the first one made.
        async with self._making.setdefault(number, asyncio.Lock()):
            draft = await self.get(number)
            # What was made stays: a second request answers with the same campaign.
            if draft.campaign_id is not None:
                return draft
            try:
                found = await self._look(draft, make=True)
            except TaskRefusedError as error:
                raise NotReadyError(error.text) from error
            if found.campaign is None:
                raise NotReadyError(_what_is_missing(found.understood))
            stored = _stored(found.campaign, draft, name)
            campaign_id = await self._campaigns.add(stored, _key(draft, "campaign"))
            jobs = (
                await self._jobs.identify(campaign_id, None, _key(draft, "identification")),
                await self._jobs.diagnose(campaign_id, None, key=_key(draft, "diagnosis")),
            )
            return await _off_the_loop(self._drafts.keep_made, draft, campaign_id, jobs)

    async def _look(self, draft: Draft, *, make: bool) -> BroughtRead:
        if not draft.files:
            return BroughtRead(Understood(()))
        files = tuple((file.name, str(self._drafts.path(draft.id, file.number))) for file in draft.files)
        task = ReadBroughtTask(files, choices_of(draft.choices, _edits(draft.choices)), make)
        # In the turns of uploads: however files came, one worker reads what strangers sent, and no more.
        async with self._uploads.turn():
            return await self._uploads.look(task)


async def _whole(data: bytes) -> AsyncIterator[bytes]:
    yield data


def _key(draft: Draft, made: str) -> RequestKey:
    """Name what is made of a draft as it stands, so that it is made once however often that is tried."""
    # A client's key has no blank, so these are of drafts alone.
    return RequestKey(f"{made} of draft {draft.id} of {draft.created_at}, revision {draft.revision}", "")


def _stored(made: CampaignRead, draft: Draft, name: str | None) -> NewCampaign:
    who = {key: draft.choices[key] for key in _WHO if draft.choices.get(key)}
    summary = replace(made.summary, **who)
    return NewCampaign(name or _name_of(draft), made.robot, summary, made.campaign, made.archive)


def _name_of(draft: Draft) -> str:
    """Return the folder that the files came in, or the name of the first table."""
    names = [file.name for file in draft.files]
    first = next((name for name in names if not name.endswith(".json")), names[0])
    return first.split("/")[0].rsplit(".", 1)[0][:200] or "campaign"


def _edits(choices: Mapping[str, Any]) -> list[str]:
    """Return a sentence for every line that was not read as it came: results show them."""
    told = []
    for name, said in (choices.get("files") or {}).items():
        left_out = set(said.get("left_out") or ())
        told += [f"Line {line} of {name} was left out by hand." for line in sorted(left_out)]
        edited = (int(line) for line in said.get("lines") or ())
        told += [
            f"Line {line} of {name} was corrected by hand." for line in sorted(edited) if line not in left_out
        ]
    return told


def _what_is_missing(understood: Understood) -> str:
    if understood.fault is not None:
        place = understood.fault
        where = (
            f"{place.file}, line {place.line}: " if place.line else f"{place.file}: " if place.file else ""
        )
        return f"{where}{place.sentence}."
    if understood.questions:
        return IN_ENGLISH.spoken(understood.questions[0].sentence)
    return "No file has been added yet; add a file."


async def _off_the_loop(work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    return await asyncio.to_thread(work, *args, **kwargs)


_AT_ONCE: Final = 500


async def draft_of_series(series: SeriesRepository, drafts: DraftService, series_id: int) -> Draft:
    """Return a new draft with what a series holds; raises NotFoundError, ConflictError, NotReadyError."""
    record = await series.get(series_id)
    if not record.readings:
        raise NotReadyError(message("refused.empty_series", series=series_id))
    draft = await drafts.create()
    return await drafts.receive(draft.id, f"series {series_id}.csv", _table(series, record))


async def _table(series: SeriesRepository, record: SeriesRecord) -> AsyncIterator[bytes]:
    yield _lines([record.series.columns])
    for after in range(0, record.readings, _AT_ONCE):
        page = await series.readings(record.id, Page(after, min(_AT_ONCE, record.readings - after)))
        yield _lines(one.values for one in page)


def _lines(rows: Iterable[tuple[str, ...] | Values]) -> bytes:
    written = io.StringIO()
    csv.writer(written).writerows([_cell(value) for value in row] for row in rows)
    return written.getvalue().encode()


def _cell(value: str | float | None) -> str | float | None:
    return written_text(value) if isinstance(value, str) else value
