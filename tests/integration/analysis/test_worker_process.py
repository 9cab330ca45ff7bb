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


async def nobody(fraction, doing):
    pass


async def test_the_answer_comes_back_with_the_progress_on_the_way():
    told = []

    async def tell(fraction, doing):
        told.append((fraction, doing))

    answer = await perform_in_worker(Echo({"x": [1.0] * 100_000}), tell)

    assert answer == {"x": [1.0] * 100_000}
    assert told == [(0.5, "half way")]


async def test_a_sentence_of_the_task_arrives_as_it_was():
    with pytest.raises(TaskRefusedError, match=r"^No row 3\.$"):
        await perform_in_worker(Fail(ConfigurationError("No row 3.")), nobody)


async def test_a_fault_of_the_program_is_told_as_one():
    with pytest.raises(
        TaskRefusedError, match=r"The program failed at this task \(ZeroDivisionError: by 0\)"
    ):
        await perform_in_worker(Fail(ZeroDivisionError("by 0")), nobody)


async def test_a_worker_that_dies_is_told_with_its_last_words():
    with pytest.raises(
        WorkerDiedError, match="ended with status 7 before it answered; it last said: last words"
    ):
        await perform_in_worker(Die(7), nobody)


async def test_cancelling_kills_the_process():
    started = asyncio.get_running_loop().create_future()

    async def tell(_fraction, doing):
        started.set_result(int(doing))

    work = asyncio.create_task(perform_in_worker(Hang(), tell))
    process_id = await started
    work.cancel()
    with pytest.raises(asyncio.CancelledError):
        await work

    with pytest.raises(ProcessLookupError):
        os.kill(process_id, 0)
