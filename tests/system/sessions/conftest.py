"""Sessions with processes of their own: cells, services, workers."""

import pytest


@pytest.fixture(autouse=True, scope="module")
def in_forked_processes(forked_processes):
    """No session depends on what its processes load."""
