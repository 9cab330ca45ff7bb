"""The bench fixture: every contract runs in memory and over a loopback socket."""

from collections.abc import AsyncIterator

import pytest

from tests.contract.benches import Bench


@pytest.fixture(params=["memory", "socket"])
async def bench(request: pytest.FixtureRequest) -> AsyncIterator[Bench]:
    made = Bench(request.param)
    await made.listen()
    yield made
    await made.close()
