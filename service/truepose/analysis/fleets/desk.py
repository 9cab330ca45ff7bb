"""Fleets of a plant: what each collected campaign tells, kept beside the database for who compares them."""

import asyncio
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.analysis.drawing import DrawingDesk
from truepose.domain.errors import TrueposeError
from truepose.storage.files.drawn import DrawnFolder, drawn_of
from truepose.storage.plant.campaigns import CollectedCampaigns
from truepose.storage.plant.looking import ResultSeen
from truepose.version import program_sha256

_MOST_BYTES: Final = 1024 * 2**20  # some eight thousand campaigns
_TOGETHER: Final = 20  # campaigns that a worker process is asked for
_FRAME: Final = struct.Struct("<?Q")  # whether it failed, and the length of what follows


@dataclass(frozen=True, slots=True)
class Collected:
    """A campaign with what it tells, or why it tells nothing."""

    seen: ResultSeen
    told: bytes  # as `told_from` reads it; empty: nothing
    why: str = ""


class FleetDesk:
    """Has campaigns tell what they do, each once for this version of the program."""

    def __init__(self, campaigns: CollectedCampaigns, kept: DrawnFolder, drawing: DrawingDesk) -> None:
        self._campaigns = campaigns
        self._kept = kept
        self._drawing = drawing

    @staticmethod
    def folder(database: Path) -> DrawnFolder:
        """Return the folder in which answers are kept: it may be thrown away at any time."""
        return DrawnFolder(database.with_name(f"{database.name}.fleets"), _MOST_BYTES)

    async def campaigns(self) -> list[ResultSeen]:
        """Return all campaigns that were collected, in their order."""
        return await self._campaigns.all()

    async def told(self, campaigns: Sequence[ResultSeen]) -> tuple[Collected, ...]:
        """Return what campaigns tell; who was not asked before is asked in a worker process."""
        program = await asyncio.to_thread(program_sha256)
        known = {}
        for one in campaigns:
            kept = await asyncio.to_thread(self._kept.get, _of(program, one))
            if kept is not None:
                known[one.id] = Collected(one, kept.body)
        missing = [one for one in campaigns if one.id not in known]
        for first in range(0, len(missing), _TOGETHER):
            for found in await self._asked(missing[first : first + _TOGETHER]):
                known[found.seen.id] = found
                if found.told:
                    await asyncio.to_thread(self._kept.keep, _of(program, found.seen), drawn_of(found.told))
        return tuple(known[one.id] for one in campaigns)

    async def _asked(self, campaigns: Sequence[ResultSeen]) -> list[Collected]:
        contents = tuple([await self._campaigns.content(one) for one in campaigns])
        answers = _unframed(await self._drawing.draw(told_of_all, contents))
        return [
            Collected(one, b"", text.decode()) if failed else Collected(one, text)
            for one, (failed, text) in zip(campaigns, answers, strict=True)
        ]


def _of(program: str, campaign: ResultSeen) -> str:
    return f"{program}\n{campaign.branch_id} {campaign.record_id}"


def told_of_all(contents: Sequence[bytes]) -> bytes:
    """Return what stored campaigns tell, or why one does not, one frame each.

    In a worker process, where the numerics are imported, which takes longer than a campaign.
    """
    import numpy as np

    from truepose.analysis.fleets.told import tell

    frames = []
    for content in contents:
        try:
            failed, text = False, tell(content, np.random.SeedSequence(0))
        except TrueposeError as error:
            failed, text = True, str(error).encode()
        frames.append(_FRAME.pack(failed, len(text)) + text)
    return b"".join(frames)


def _unframed(data: bytes) -> Iterator[tuple[bool, bytes]]:
    at = 0
    while at < len(data):
        failed, size = _FRAME.unpack_from(data, at)
        at += _FRAME.size + size
        yield failed, data[at - size : at]
