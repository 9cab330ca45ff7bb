"""Sessions with processes of their own: cells, services, workers."""

import asyncio

import pytest

from tests.helpers.forked import forked


@pytest.fixture(autouse=True)
def processes_that_have_everything_loaded(monkeypatch):
    """Fork what is started here: no session depends on what its processes load."""
    monkeypatch.setattr(asyncio, "create_subprocess_exec", forked)
