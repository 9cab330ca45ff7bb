"""Cells for the tests of simulators."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from truepose_simulators.cell.clock import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.scenarios.file import load_scenario


@pytest.fixture
def make_cell() -> Callable[..., Cell]:
    """Build a cell at pace 0 from a shipped scenario; keywords replace parts of the scenario."""

    def make(name: str = "irb120-tilted", *, seed: int = 1, **changes: Any) -> Cell:
        return Cell(replace(load_scenario(name), **changes), seed, CellClock(0))

    return make
