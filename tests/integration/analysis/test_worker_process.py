"""A worker answers, refuses, dies or is killed, and the service always knows which."""

import asyncio
import os
import sys
from dataclasses import dataclass

import pytest

from truepose.analysis.errors import WorkerDiedError
from truepose.analysis.job_queue.supervisor import TaskRefusedError, perform_in_worker
from truepose.domain.errors import ConfigurationError


@dataclass(frozen=True)
class Echo:
    value: object

    def perform(self, report):
        report(0.5, "half way")
        sys.stdout.write("a library that prints to standard output\n")
        return self.value


@dataclass(frozen=True)
class AnswerOfNoModule:
    def perform(self, report):
        return lambda: None


@dataclass(frozen=True)
class Fail:
    error: Exception

    def perform(self, report):
        raise self.error


@dataclass(frozen=True)
class Die:
    status: int

    def perform(self, report):
        sys.stderr.write("last words\n")
        sys.stderr.flush()
        os._exit(self.status)


@dataclass(frozen=True)
class Hang:
    def perform(self, report):
        import time

        report(0.1, str(os.getpid()))
        time.sleep(600)


@dataclass(frozen=True)
class Flood:
    """Tells so little that a pipe holds it, then more than one holds, which nobody waits for."""

    def perform(self, report):
        report(0.1, str(os.getpid()))
        report(0.2, "x" * 2**20)


@dataclass(frozen=True)
class Shout:
    value: str

    def perform(self, report):
        sys.stderr.write(f"{'x' * 2**20} and at last\n")
        return self.value


@dataclass(frozen=True)
class Signalled:
    number: int

    def perform(self, report):
        os.kill(os.getpid(), self.number)


FAULT = "The program failed at this task"


async def nobody(fraction, doing):
    pass


async def test_the_answer_comes_back_with_the_progress_on_the_way():
    told = []

    async def tell(fraction, doing):
        told.append((fraction, doing))

    answer = await perform_in_worker(Echo({"x": [1.0] * 100_000}), tell)

    assert answer == {"x": [1.0] * 100_000}
    assert told == [(0.5, "half way")]


@pytest.mark.parametrize(
    ("task", "error", "said"),
    [
        (Fail(ConfigurationError("No row 3.")), TaskRefusedError, r"^No row 3\.$"),
        (Fail(ZeroDivisionError("by 0")), TaskRefusedError, rf"{FAULT} \(ZeroDivisionError: by 0\)"),
        (AnswerOfNoModule(), TaskRefusedError, rf"{FAULT} \(.*local object"),
        (Die(7), WorkerDiedError, "status 7 before it answered; its last message was: last words"),
    ],
    ids=["refused", "a fault of the program", "an answer that cannot travel", "dead"],
)
async def test_a_worker_without_an_answer_is_told_with_its_words(task, error, said):
    with pytest.raises(error, match=said):
        await perform_in_worker(task, nobody)


async def test_a_line_of_the_worker_that_is_too_long_for_a_log_stops_nobody():
    assert await asyncio.wait_for(perform_in_worker(Shout("answer"), nobody), 20) == "answer"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere signals have other numbers")
@pytest.mark.parametrize(("number", "named"), [(15, "SIGTERM"), (40, "40")])
async def test_a_worker_that_a_signal_ends_is_told_with_it(number, named):
    with pytest.raises(WorkerDiedError, match=f"was ended by signal {named} before it answered"):
        await perform_in_worker(Signalled(number), nobody)


@pytest.mark.parametrize("task", [Hang(), Flood()], ids=["computing", "telling"])
async def test_cancelling_kills_the_process(task):
    started = asyncio.get_running_loop().create_future()

    async def tell(_fraction, doing):
        started.set_result(int(doing))
        await asyncio.sleep(600)

    work = asyncio.create_task(perform_in_worker(task, tell))
    process_id = await started
    await asyncio.sleep(0.2)  # in which pipes fill
    work.cancel()
    with pytest.raises(asyncio.CancelledError):
        await asyncio.wait_for(work, 60)

    with pytest.raises(ProcessLookupError):
        os.kill(process_id, 0)
