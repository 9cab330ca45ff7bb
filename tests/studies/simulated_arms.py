"""Simulated arms as studies ask them: what a recording says in its files, and where the tool truly is."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign
from truepose.exchange.campaigns.folder import read_campaign
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import write_campaign


def read_back(recording: Any, write: Callable[[Any, Path], object] = write_campaign) -> Campaign:
    """Return the campaign of a recording, written and read back from its files."""
    with tempfile.TemporaryDirectory() as folder:
        write(recording, Path(folder))
        return read_campaign(Path(folder))


def true_nests_mm(cell: Cell, joints_rad: FloatArray, time_s: float = 0.0) -> FloatArray:
    """Return where all nests truly are, shape (n, nests, 3); configurations (n, J) are reached from below.

    Scatter of the arm is not included.
    """
    n = len(joints_rad)
    stops = cell.conditions(joints_rad, np.ones_like(joints_rad), np.full(n, time_s), np.ones(n))
    return cell.true_positions(stops)


def of_nest(nests_mm: FloatArray, nest: IntArray) -> FloatArray:
    """Return the place (n, 3) of one nest at each stop, counted from 1."""
    return nests_mm[np.arange(len(nest)), nest - 1]
