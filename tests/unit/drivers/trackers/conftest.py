"""An emScon tracker of points that is initialised, and the server in memory that it speaks to."""

import pytest

from tests.helpers.instruments.emscon_in_memory import FakeTracker, ready_tracker
from truepose_drivers.leica_emscon.driver import LaserTracker


@pytest.fixture
def emscon() -> FakeTracker:
    return FakeTracker()


@pytest.fixture
async def tracker(emscon: FakeTracker) -> LaserTracker:
    return await ready_tracker(emscon)
