"""Jobs whose records are refused: nothing that was computed is lost, and none looks as if it still ran."""

import asyncio
import itertools

import pytest

from truepose.analysis.job_queue import queue as queueing
from truepose.analysis.job_queue.queue import JobQueue, Work
from truepose.messages.catalogue import english
from truepose.storage.errors import ConflictError, ServerAwayError, StorageUnavailableError
from truepose.storage.records import JobKind, JobState

pytestmark = pytest.mark.simulated_time
AWAY = ServerAwayError("The server does not answer.")


class Storage:
    """Keeps states and results; `refusals` says of each write by turns whether it is refused."""

    def __init__(self, *refusals):
        self._refusals = itertools.chain(refusals, itertools.repeat(None))
        self.states, self.progress, self.results = [], [], []
        self.there = asyncio.Event()
        self.there.set()

    def _write(self):
        refused = next(self._refusals)
        if refused is not None:
            raise refused
        if self.states and self.states[-1][0].final:
            raise ConflictError("The job has already ended.")

    async def add(self, kind, request, key):
        return 1

    async def taken(self, kind, count):
        return []

    async def change_state(self, job_id, state, message, code=None):
        self._write()
        self.states.append((state, message))

    async def tell_progress(self, job_id, fraction, doing):
        self._write()
        self.progress.append(fraction)

    async def keep(self, job_id, answer):
        self._write()
        self.results.append(answer)
        self.states.append((JobState.SUCCEEDED, "Done."))
        return 1

    async def writable(self):
        await self.there.wait()


class Worker:
    """Counts how often something was computed."""

    def __init__(self, error=None):
        self.error, self.performed = error, 0

    async def __call__(self, task, told):
        self.performed += 1
        await told(0.5, "halfway")
        if self.error is not None:
            raise self.error
        return "answer"


async def load():
    return None


async def begun(storage, worker):
    queue = JobQueue(storage, worker)
    await queue.add(Work(JobKind.IDENTIFICATION, {}, 1, load, storage.keep), None)
    return queue


async def ended(queue):
    while queue.under_way(1):
        await asyncio.sleep(0.05)


STARTING, TOLD, STORED = 0, 1, 2  # the writes of a job, by their order


@pytest.mark.parametrize("times", [1, 3, 50])
@pytest.mark.parametrize("which", [STARTING, STORED])
async def test_a_result_is_kept_once_storage_takes_it_and_computed_once(which, times):
    storage, worker = Storage(*[None] * which, *[AWAY] * times), Worker()

    await ended(await begun(storage, worker))

    assert [state for state, _ in storage.states] == [JobState.RUNNING, JobState.SUCCEEDED]
    assert (storage.results, worker.performed) == (["answer"], 1)


async def test_progress_that_is_refused_ends_nothing():
    storage, worker = Storage(*[None] * TOLD, AWAY), Worker()

    await ended(await begun(storage, worker))

    assert (storage.progress, storage.results, worker.performed) == ([], ["answer"], 1)


@pytest.mark.parametrize(
    "error", [StorageUnavailableError("The worker ended."), ZeroDivisionError("by zero")]
)
@pytest.mark.parametrize("times", [1, 3, 300])
async def test_that_a_job_failed_is_said_once_storage_takes_it(error, times):
    storage = Storage(None, None, *[AWAY] * times)

    await ended(await begun(storage, Worker(error)))

    assert [state for state, _ in storage.states] == [JobState.RUNNING, JobState.FAILED]
    assert str(error) in english(storage.states[-1][1])


async def test_a_failure_whose_words_cannot_be_written_is_one_in_other_words():
    storage = Storage(None, None, UnicodeEncodeError("utf-8", "half a letter", 0, 1, "no surrogates"))

    await ended(await begun(storage, Worker(FileNotFoundError("half a letter.csv"))))

    assert [state for state, _ in storage.states] == [JobState.RUNNING, JobState.FAILED]
    assert "UnicodeEncodeError" in english(storage.states[-1][1])


async def test_a_result_that_alone_is_refused_has_its_job_fail_with_the_reason():
    full = StorageUnavailableError("There is no room for 40 MB.")
    storage = Storage(None, None, *[full] * queueing._TRIES)

    await ended(await begun(storage, Worker()))

    assert storage.states[-1] == (JobState.FAILED, str(full))
    assert storage.results == []


async def waiting():
    """Return a storage that has refused a result once and is not there yet, and the queue with that job."""
    storage = Storage(None, None, AWAY)
    storage.there.clear()
    queue = await begun(storage, Worker())
    await asyncio.sleep(1)
    return storage, queue


async def test_while_a_result_waits_it_is_said_why():
    storage, queue = await waiting()

    meanwhile = queue.foreseen(1)
    storage.there.set()
    await ended(queue)

    assert meanwhile.refused == str(AWAY)
    assert storage.results == ["answer"]


async def test_a_job_that_was_cancelled_while_its_result_waited_keeps_that_end():
    storage, queue = await waiting()

    await storage.change_state(1, JobState.CANCELLED, "Cancelled.")
    storage.there.set()
    await ended(queue)

    assert [state for state, _ in storage.states] == [JobState.RUNNING, JobState.CANCELLED]
    assert storage.results == []
