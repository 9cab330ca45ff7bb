import pytest

from truepose_simulators.cell.environment import CellClock


class Wall:
    """A wall clock that is moved by hand, and notes what was slept."""

    def __init__(self):
        self.now_s = 1000.0
        self.slept_s = []

    def __call__(self):
        return self.now_s

    async def sleep(self, duration_s):
        self.slept_s.append(duration_s)
        self.now_s += duration_s


async def test_at_pace_0_sleeping_moves_cell_time_and_costs_no_wall_time():
    wall = Wall()
    clock = CellClock(0, wall_s=wall, wall_sleep=wall.sleep)

    await clock.sleep(3600.0)
    wall.now_s += 5.0

    assert clock.now_s == 3600.0
    assert wall.slept_s == []


async def test_at_pace_1_cell_time_is_wall_time_since_the_start():
    wall = Wall()
    clock = CellClock(1, wall_s=wall, wall_sleep=wall.sleep)

    await clock.sleep(2.5)
    wall.now_s += 1.0

    assert clock.now_s == pytest.approx(3.5, abs=1e-9)
    assert wall.slept_s == [2.5]
