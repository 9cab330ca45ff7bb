"""The systemd unit, and what the service tells whoever started it."""

import asyncio
import inspect
import re
import socket
import sys
from importlib.resources import files

import pytest

from tests.helpers.machine import HANGS_S
from truepose.app import server
from truepose.cli.services import serve_command

UNIT = files("truepose").joinpath("app", "deployment", "truepose.service").read_text(encoding="utf-8")


def settings():
    lines = (line for line in UNIT.splitlines() if line and not line.startswith(("#", "[")))
    return dict(line.split("=", 1) for line in lines)


def test_the_unit_starts_the_service_with_options_that_there_are():
    known = {name.replace("_", "-") for name in inspect.signature(serve_command).parameters}

    options = re.findall(r" --([\w-]+)", settings()["ExecStart"])
    assert {"cell", "database", "backup-to"} <= set(options) <= known


def test_the_unit_closes_what_the_service_does_not_need():
    said = settings()

    assert said["Type"] == "notify"
    assert said["ProtectSystem"] == "strict"
    assert said["NoNewPrivileges"] == "yes"
    assert said["CapabilityBoundingSet"] == ""
    assert f"/var/lib/{said['StateDirectory']}/" in said["ExecStart"]


@pytest.fixture
def manager(tmp_path, monkeypatch):
    if sys.platform == "win32":
        pytest.skip("there is no systemd")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(str(tmp_path / "notify"))
        listener.setblocking(False)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        yield listener


def test_the_service_manager_is_told(manager):
    server.tell("READY=1")

    assert manager.recv(100) == b"READY=1"


def test_where_there_is_none_nobody_is_told(monkeypatch, tmp_path):
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    server.tell("READY=1")
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "gone"))
    server.tell("READY=1")

    assert [*tmp_path.iterdir()] == []


async def test_a_watchdog_hears_that_the_loop_turns(manager, monkeypatch):
    monkeypatch.setenv("WATCHDOG_USEC", "30000")

    telling = asyncio.create_task(server.keep_telling())
    async with asyncio.timeout(HANGS_S):
        for _ in range(3):
            assert await asyncio.get_running_loop().sock_recv(manager, 100) == b"WATCHDOG=1"
    telling.cancel()


async def test_without_a_watchdog_there_is_nothing_to_tell(monkeypatch):
    monkeypatch.delenv("WATCHDOG_USEC", raising=False)

    telling = asyncio.create_task(server.keep_telling())
    await asyncio.wait({telling}, timeout=HANGS_S)

    assert telling.done() and telling.exception() is None
