"""Cells with a person in them."""

import pytest

from tests.unit.simulators.hands.deeds import POSE, clamp_all, move


@pytest.fixture
def lrmate(make_cell):
    def make(name="lrmate-tilted", **changes):
        return make_cell(name, **{"seed": 2, **changes})

    return make


@pytest.fixture
async def posed(lrmate):
    """A cell with clamped cups, the robot in a pose and the ballbar on its calibrator."""

    async def make(**changes):
        cell = lrmate(**changes)
        await clamp_all(cell)
        await move(cell, POSE)
        cell.hands.do("calibrator", {"bars": "base"})
        return cell

    return make
