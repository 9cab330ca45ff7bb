"""What goes on beside a service: begun again where it ends by a fault, ended with the service."""

import asyncio
import contextlib

from tests.helpers.machine import HANGS_S
from truepose.app import startup


async def test_a_companion_that_ends_by_a_fault_is_told_and_begun_again(monkeypatch, caplog):
    monkeypatch.setattr(startup, "_AGAIN_S", 0.0)
    begun, second = [], asyncio.Event()

    async def follow():
        begun.append(len(begun))
        if len(begun) == 1:
            raise ValueError("a stray line")
        second.set()
        await asyncio.Event().wait()

    async with contextlib.AsyncExitStack() as stack:
        startup.beside(stack, follow, "storage guard")
        async with asyncio.timeout(HANGS_S):
            await second.wait()

    assert begun == [0, 1]
    assert "storage guard" in caplog.text and "a stray line" in caplog.text


async def test_a_companion_ends_with_the_service():
    ended = []

    async def follow():
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("in order")

    async with contextlib.AsyncExitStack() as stack:
        startup.beside(stack, follow, "storage guard")
        await asyncio.sleep(0)

    assert ended == ["in order"]
