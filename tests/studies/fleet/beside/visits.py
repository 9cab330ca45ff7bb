"""One visit of an instrument to a robot in the simulated physics: whatever a plant may do to it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from tests.studies.fleet.simulated import RobotTruth, campaign_of, draw_robot, draw_type, name
from truepose.domain.campaign import Campaign
from truepose.fleet.campaigns import FleetCampaign, information_of
from truepose_simulators.cell.drawn_effects import EverydaySizes, draw_everyday
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.arm import CarriedMass
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ConfiguredLink, Scenario

DAYS_A_MONTH: Final = 30.0
_ARM: Final = ARMS["irb120"]
_TOOL: Final = CarriedMass(6, 2.7, (50.0, 25.0, 100.0))  # as of the shipped cells
_OF_TYPE: Final = frozenset({"joint_harmonics", "backlash"})  # the type has them already
_OF_TOOL: Final = frozenset({"nest_offset"})
_OF_VISIT: Final = frozenset({"base_drift", "thermal_growth"})


def _as_it_is(value: Campaign) -> Campaign:
    return value


@dataclass(frozen=True)
class Visit:
    """A campaign to be: what is said of it, and what truly happened."""

    robot: int  # as it is said
    month: int
    tracker: str = "tracker A"
    truly: int | None = None  # robot that stood there, if it was another
    links: tuple[ConfiguredLink, ...] = ()  # in place of the robot's own, by joint
    changes: tuple[PlantedChange, ...] = ()  # besides
    cell: Callable[[Scenario], Scenario] = field(default=lambda scenario: scenario)
    written: Callable[[Campaign], Campaign] = _as_it_is  # what became of its file
    configurations: int = 30
    day: float | None = None  # as it is said; None: of its month

    @property
    def said_day(self) -> float:
        """Day that stands in its file."""
        return self.month * DAYS_A_MONTH if self.day is None else self.day


@dataclass(frozen=True)
class Robots:
    """Robots of one type."""

    seed: int
    each: tuple[RobotTruth, ...]
    everyday: bool

    def recorded(self, visit: Visit, number: int) -> Campaign:
        """Record the campaign of a visit."""
        truth = self.each[visit.robot if visit.truly is None else visit.truly]
        given = {link.joint: link for link in visit.links}
        plain = load_scenario("irb120-clean")
        scenario = replace(
            plain,
            links=tuple(given.get(link.joint, link) for link in truth.links),
            effects=(*truth.changes, *self._everyday(truth.number, number), *visit.changes),
        )
        seed = int(np.random.SeedSequence([self.seed, number]).generate_state(1)[0])
        cell = Cell(visit.cell(scenario), seed, CellClock(0))
        wishes = RecordingRequest(configurations=visit.configurations, validation=0, attachments=1)
        return visit.written(campaign_of(cell, wishes))

    def _everyday(self, robot: int, number: int) -> tuple[PlantedChange, ...]:
        """Return what everyday robots have besides: of the robot, of the tool, and of the day."""
        if not self.everyday:
            return ()

        def drawn(*entropy: int) -> tuple[PlantedChange, ...]:
            rng = np.random.default_rng([self.seed, *entropy])
            return draw_everyday(EverydaySizes(), _ARM, _TOOL, 3, rng)

        not_own = _OF_TYPE | _OF_TOOL | _OF_VISIT
        return (
            *(one for one in drawn(1, robot) if one.name not in not_own),
            *(one for one in drawn(2) if one.name in _OF_TOOL),
            *(one for one in drawn(3, number) if one.name in _OF_VISIT),
        )


def draw_robots(seed: int, count: int, *, everyday: bool = False) -> Robots:
    """Draw robots of one type."""
    rng = np.random.default_rng([seed, 31])
    of = draw_type(rng)
    return Robots(seed, tuple(draw_robot(of, k, rng) for k in range(count)), everyday)


def measured(robots: Robots, visits: list[Visit]) -> list[FleetCampaign]:
    """Record and identify all visits."""
    return [
        FleetCampaign(
            name(visit.robot), visit.tracker, visit.said_day, information_of(robots.recorded(visit, number))
        )
        for number, visit in enumerate(visits)
    ]
