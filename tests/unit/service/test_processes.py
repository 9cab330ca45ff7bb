"""How processes end, also as Windows has it: a loop without signal handlers, no groups, other flags."""

import asyncio
import contextlib
import os
import signal
import subprocess
import sys

import pytest

from tests.helpers.machine import HANGS_S, KILLING_SIGNALS
from truepose.processes import asked_to_end, in_own_group, interrupt_this_process, kill_group
from truepose_simulators import __main__

BREAK = getattr(signal, "SIGBREAK", None) or signal.SIGUSR1
SYSTEMS = ("as it is", "as Windows is")


@pytest.fixture(params=SYSTEMS)
def system(request, monkeypatch):
    """The loop of this system, or one that takes no signal handlers, beside signals that Windows has."""
    if request.param == "as Windows is":

        def refused(_self, _number, _callback, *_arguments):
            raise NotImplementedError

        monkeypatch.setattr(asyncio.SelectorEventLoop, "add_signal_handler", refused)
        monkeypatch.setattr(signal, "SIGBREAK", BREAK, raising=False)
    return request.param


def asking(system):
    return [signal.SIGINT, signal.SIGTERM, *([BREAK] if system == "as Windows is" else [])]


@pytest.fixture
def handlers():
    """Signal handlers as they were before a test."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, BREAK)}
    yield before
    for number, handler in before.items():
        signal.signal(number, handler)


async def test_whoever_asks_a_process_to_end_is_heard_by_its_loop(system, handlers):
    heard = []

    with asked_to_end(lambda: heard.append(asyncio.get_running_loop())):
        for number in asking(system):
            signal.raise_signal(number)
            await asyncio.sleep(0.05)

    assert heard == [asyncio.get_running_loop()] * len(asking(system))


async def test_once_nobody_listens_any_more_a_process_is_ended_by_the_system(system, handlers):
    with asked_to_end(lambda: None):
        pass

    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


async def test_a_simulated_cell_hears_whoever_asks_it_to_end(system, handlers):
    for number in asking(system):
        asked = __main__.end_event()
        signal.raise_signal(number)
        await asyncio.wait_for(asked.wait(), HANGS_S)
        assert asked.is_set()


def test_a_thread_interrupts_its_process_where_a_kill_would_end_it_on_the_spot(handlers, monkeypatch):
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell's background process has not
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(os, "kill", lambda pid, number: pytest.fail("ended on the spot"))

    with pytest.raises(KeyboardInterrupt):
        interrupt_this_process()


def test_a_process_of_windows_gets_a_group_by_a_flag(monkeypatch):
    monkeypatch.delattr(subprocess, "CREATE_NEW_PROCESS_GROUP", raising=False)
    assert in_own_group() == {"start_new_session": True}

    monkeypatch.setattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0x200, raising=False)

    assert in_own_group() == {"creationflags": 0x200}


@KILLING_SIGNALS
@pytest.mark.parametrize("grouped", [True, False])
async def test_a_process_is_killed_once_and_may_have_ended(monkeypatch, grouped):
    if not grouped:
        monkeypatch.delattr(os, "killpg", raising=False)
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", "input()", stdin=asyncio.subprocess.PIPE, start_new_session=True
    )

    kill_group(process)
    async with asyncio.timeout(HANGS_S):
        status = await process.wait()
    kill_group(process)

    assert status == -9
    with contextlib.suppress(OSError):
        process.stdin.close()
