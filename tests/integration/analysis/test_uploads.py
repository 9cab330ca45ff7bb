"""Uploads take turns, and what one of them brings takes a known part of the computer."""

import asyncio
import subprocess
import sys
from dataclasses import dataclass

import pytest

from tests.helpers.domain.builders import make_campaign
from tests.helpers.machine import HANGS_S
from truepose.analysis.errors import BusyError
from truepose.analysis.job_queue.file_tasks import CampaignRead
from truepose.analysis.job_queue.supervisor import TaskRefusedError, perform_in_worker
from truepose.analysis.job_queue.uploads import Uploads
from truepose.exchange.campaigns.zip_file import write_campaign_zip

MB = 2**20
READ_ONE = """
import sys
from pathlib import Path
from truepose.analysis.job_queue.tasks import ReadCampaignTask

ReadCampaignTask(Path(sys.argv[1]).read_bytes(), "elbow.zip").perform(None)
print(*{"sqlalchemy", "scipy"} & sys.modules.keys())
"""


@dataclass(frozen=True)
class Hoard:
    megabytes: int

    def perform(self, report):
        return len(bytearray(self.megabytes * MB))


async def nobody(fraction, doing):
    pass


class Reading:
    """Reads when it is told to."""

    def __init__(self):
        self.begun = []
        self.go_on = asyncio.Event()
        self.cancelled = 0

    async def __call__(self, task, told):
        self.begun.append(task.name)
        try:
            await self.go_on.wait()
        except asyncio.CancelledError:
            self.cancelled += 1
            raise
        return CampaignRead("elbow", None, b"")


async def soon(condition):
    async with asyncio.timeout(HANGS_S):
        while not condition():
            await asyncio.sleep(0)


async def test_a_task_that_needs_more_memory_than_it_is_given_is_refused_with_a_sentence():
    with pytest.raises(TaskRefusedError, match="needs more than the 512 MB of memory allowed"):
        await perform_in_worker(Hoard(600), nobody, memory_bytes=512 * MB)


async def test_a_task_that_keeps_within_its_memory_is_done():
    assert await perform_in_worker(Hoard(100), nobody, memory_bytes=512 * MB) == 100 * MB


async def test_an_archive_is_read_in_a_worker():
    found = await Uploads().read(write_campaign_zip(make_campaign()), "left arm")

    assert (found.robot, found.summary.calibration_points) == ("elbow", 3)


async def test_a_list_of_campaigns_shows_no_thousand_sentences_of_one():
    notes = tuple(f"Note {number}." for number in range(1000))

    found = await Uploads().read(write_campaign_zip(make_campaign(notes=notes)), "left arm")

    assert len(found.summary.notes) == 101
    assert found.summary.notes[-1] == "The archive lists 900 more such remarks."


async def test_one_archive_is_read_at_a_time():
    reading = Reading()
    uploads = Uploads(reading)

    both = asyncio.gather(uploads.read(b"", "first"), uploads.read(b"", "second"))
    await soon(lambda: reading.begun)
    assert reading.begun == ["first"]
    reading.go_on.set()
    await both

    assert reading.begun == ["first", "second"]


async def test_more_than_can_wait_are_sent_away_at_once():
    uploads, leave = Uploads(Reading()), asyncio.Event()

    async def come():
        async with uploads.turn():
            await leave.wait()

    inside = [asyncio.create_task(come()) for _ in range(6)]
    await asyncio.sleep(0)
    with pytest.raises(BusyError, match="Too many requests of this kind are waiting"):
        await come()
    leave.set()
    await asyncio.gather(*inside)

    await come()  # there is room again


async def test_who_waits_too_long_is_sent_away():
    uploads = Uploads(Reading(), patience_s=0.01)

    async with uploads.turn(), uploads.turn():
        with pytest.raises(BusyError, match="Too many requests of this kind are waiting"):
            async with uploads.turn():
                pass
    async with uploads.turn(), uploads.turn():
        pass


async def test_a_reading_that_nobody_wants_any_more_lets_the_next_one_begin():
    reading = Reading()
    uploads = Uploads(reading)
    first = asyncio.create_task(uploads.read(b"", "first"))
    second = asyncio.create_task(uploads.read(b"", "second"))
    await soon(lambda: reading.begun)

    first.cancel()
    await soon(lambda: len(reading.begun) == 2)
    reading.go_on.set()

    assert (await second).robot == "elbow"
    assert reading.cancelled == 1


def test_to_read_an_upload_takes_neither_the_database_nor_the_numerics(tmp_path):
    file = tmp_path / "elbow.zip"
    file.write_bytes(write_campaign_zip(make_campaign()))

    read = subprocess.run([sys.executable, "-c", READ_ONE, file], capture_output=True, text=True, check=True)

    assert read.stdout.split() == []  # each would make whoever uploads wait for its import
