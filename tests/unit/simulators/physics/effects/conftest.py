"""Effects on a nominal IRB 120 with its typical springs: what they add is all that differs."""

import numpy as np
import pytest

from tests.unit.simulators.physics.circumstances import stops
from truepose_simulators.physics.arm import CarriedMass
from truepose_simulators.physics.effects import PlantedChange, Site, plant_effect
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.physics.true_robot import Plant, find_rest

ARM = ARMS["irb120"]
SPRINGS = np.array(ARM.typical_compliance_rad_per_n_mm)
TOOL = CarriedMass(6, 2.7, (50.0, 25.0, 100.0))


class Bench:
    """Plants effects and lets the arm come to rest with them."""

    def __init__(self, springs=SPRINGS):
        self.plant_ = Plant(ARM, np.zeros((8, 6)), springs, TOOL)

    def effect(self, name, subject, amplitude, *, from_s=0.0, seed=1, **details):
        site = Site(ARM, self.plant_.compliance_rad_per_n_mm, TOOL, 3, 23.0, (seed,))
        return plant_effect(PlantedChange(name, subject, amplitude, from_s, details), site)

    def rest(self, conditions, *effects):
        deflecting = [effect for effect in effects if hasattr(effect, "deflect")]
        masses = [
            change
            for effect in effects
            if hasattr(effect, "mass_changes")
            for change in effect.mass_changes(conditions)
        ]
        return find_rest(self.plant_, deflecting, conditions, masses)

    def added_rad(self, conditions, *effects):
        """Joint angles with the effects less those without."""
        return self.rest(conditions, *effects).angles_rad - self.rest(conditions).angles_rad

    def moved_mm(self, conditions, *effects, at_mm=(0.0, 0.0, 0.0)):
        """Way of a point of the flange frame, shape (n, 3)."""
        point = np.array([at_mm])
        with_them, without = (self.rest(conditions, *some) for some in (effects, ()))
        return (with_them.nest_positions(point) - without.nest_positions(point))[:, 0]


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def rigid_bench():
    return Bench(np.zeros(6))


@pytest.fixture
def at():
    """Conditions of stops at joint angles [deg]; keywords replace single circumstances."""

    def stops_at(rows_deg, **changes):
        return stops(np.radians(np.atleast_2d(np.array(rows_deg, dtype=float))), **changes)

    return stops_at
