"""Cells for the tests of simulators."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.unit.simulators.model_documents import model_document
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.model_file import load_model


@pytest.fixture
def write_model(tmp_path: Path) -> Callable[[dict[str, Any]], Path]:
    """Return what writes a document as a model file."""

    def write(document: dict[str, Any]) -> Path:
        path = tmp_path / "robot.json"
        path.write_text(json.dumps(document))
        return path

    return write


@pytest.fixture
def load(write_model: Callable[[dict[str, Any]], Path]) -> Callable[..., Any]:
    """Return what writes a model file with these parameters and loads it; keywords replace keys."""

    def write_and_load(*parameters: tuple[str, str, float, str], **changes: Any) -> Any:
        return load_model(write_model(model_document(*parameters, **changes)))

    return write_and_load


@pytest.fixture
def make_cell() -> Callable[..., Cell]:
    """Build a cell at pace 0 from a shipped scenario; keywords replace parts of the scenario."""

    def make(name: str = "irb120-tilted", *, seed: int = 1, **changes: Any) -> Cell:
        return Cell(replace(load_scenario(name), **changes), seed, CellClock(0))

    return make
