"""Forty robots of one type over five months in the simulated physics, and their campaigns.

What the type has (compliances, waves and lines of the gears, gaps) is drawn once and varied by 10 % a robot;
the motions of the links are each robot's own. In some robots one cause grows evenly to the size at which a
real robot shows it; of the two trackers one may drift in its lengths. Campaigns come from the simulated cell
and are read back from their files, as any campaign.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tests.studies.simulated_arms import read_back
from truepose.domain.campaign import Campaign, Stops
from truepose.fleet.campaigns import FleetCampaign, information_of
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.effects.backlash import MEASURED_GAPS_DEG
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.physics.true_robot import draw_motions
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.recording.campaign import record_in
from truepose_simulators.recording.plan import plan_stops
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ConfiguredLink, Scenario

MONTHS: Final = 5  # of which each has a campaign, beside the one at the beginning
DAYS_A_MONTH: Final = 30.0
TRACKERS: Final = ("tracker A", "tracker B")
SCALE_DRIFT: Final = 20e-6  # of length, over all months
_VARIED: Final = 0.10  # per robot, of what the type has
_EVERYDAY: Final = 1.35  # times these: waves as of everyday robots
_WAVES_DEG: Final = (0.004, 0.003, 0.001, 0.002, 0.004)  # orders 1, 2, 3, gear ratio, twice that
_LEVERS: Final = (1.0, 1.0, 1.2, 2.0, 1.6, 2.0)  # joints 1 to 6
_ARM: Final = ARMS["irb120"]

Wave = tuple[int, float, float, float]  # joint, order, amplitude [deg], phase [deg]


@dataclass(frozen=True, slots=True)
class Ageing:
    """What grows in one robot, at its size after all months."""

    effect: str
    joint: int  # 1-based
    amplitude: float  # deg, or rad/(N mm)
    order: float = 0.0  # of waves

    @property
    def subject(self) -> str:
        """What it concerns."""
        return f"joint {self.joint}"


# Sizes at which a real robot shows them: the gaps and gears of table 2.3 of A. Nubiola's thesis, 2014.
AGEING: Final = (
    Ageing("joint_harmonics", 6, 0.03, 50.0),
    Ageing("joint_harmonics", 4, 0.02, 2.0),
    Ageing("joint_harmonics", 3, 0.006, 202.0),
    Ageing("backlash", 4, 0.037),
    Ageing("backlash", 5, 0.017),
    Ageing("backlash", 6, 0.037),
    Ageing("compliance", 2, 0.5 * _ARM.typical_compliance_rad_per_n_mm[1]),
    Ageing("compliance", 3, 0.5 * _ARM.typical_compliance_rad_per_n_mm[2]),
    Ageing("compliance", 5, 0.5 * _ARM.typical_compliance_rad_per_n_mm[4]),
)


@dataclass(frozen=True, slots=True)
class TypeTruth:
    """What all robots of the type have."""

    compliance: FloatArray  # (6,)
    waves: tuple[Wave, ...]
    gaps_deg: FloatArray  # (6,)


@dataclass(frozen=True, slots=True)
class RobotTruth:
    """One robot."""

    number: int
    links: tuple[ConfiguredLink, ...]
    changes: tuple[PlantedChange, ...]
    ageing: Ageing | None = None

    def scenario(self, share: float, scale: float) -> Scenario:
        """Return its cell when so much of its ageing has come, measured with a scale error."""
        grown = () if self.ageing is None or share == 0.0 else (_grown(self.ageing, share),)
        wrong = (PlantedChange("instrument_scale", "tracker", scale),) if scale else ()
        return replace(
            load_scenario("irb120-clean"),
            name=f"robot {self.number}",
            links=self.links,
            effects=(*self.changes, *grown, *wrong),
        )


@dataclass(frozen=True, slots=True)
class FleetTruth:
    """A fleet, and what ages in it."""

    seed: int
    robots: tuple[RobotTruth, ...]
    drifting: str | None  # tracker

    @property
    def ageing(self) -> dict[str, Ageing]:
        """What grows, by robot."""
        return {name(one.number): one.ageing for one in self.robots if one.ageing is not None}


@dataclass(frozen=True, slots=True)
class Recorded:
    """One campaign of a fleet."""

    robot: str
    instrument: str
    day: float
    campaign: Campaign


def name(number: int) -> str:
    """Return the name of a robot."""
    return f"robot {number:02d}"


def draw_type(rng: np.random.Generator) -> TypeTruth:
    """Draw what the type has."""
    typical = np.array(_ARM.typical_compliance_rad_per_n_mm)
    waves = tuple(
        (joint, order, _EVERYDAY * size * lever * rng.uniform(0.5, 1.5), float(rng.uniform(-180.0, 180.0)))
        for joint, (ratio, lever) in enumerate(zip(_ARM.gear_ratio, _LEVERS, strict=True), start=1)
        for order, size in zip((1.0, 2.0, 3.0, ratio, 2.0 * ratio), _WAVES_DEG, strict=True)
    )
    return TypeTruth(typical * rng.uniform(0.8, 1.25, 6), waves, np.array(MEASURED_GAPS_DEG))


def draw_robot(
    of: TypeTruth, number: int, rng: np.random.Generator, ageing: Ageing | None = None
) -> RobotTruth:
    """Draw one robot of a type."""
    motions = draw_motions(_ARM, load_scenario("irb120-tilted").errors, rng)
    compliance = of.compliance * _varied(rng, 6)
    links = tuple(
        ConfiguredLink(k + 1, tuple(motions[k + 1, :3]), tuple(motions[k + 1, 3:]), float(compliance[k]))
        for k in range(6)
    )
    waves = [
        PlantedChange("joint_harmonics", f"joint {joint}", size * factor, details=_wave(order, phase))
        for (joint, order, size, phase), factor in zip(of.waves, _varied(rng, len(of.waves)), strict=True)
    ]
    gaps = [
        PlantedChange("backlash", f"joint {k + 1}", float(gap))
        for k, gap in enumerate(of.gaps_deg * _varied(rng, 6))
    ]
    return RobotTruth(number, links, (*waves, *gaps), ageing)


def draw_fleet(seed: int, robots: int = 40, *, ageing: int = 3, drifting: bool = True) -> FleetTruth:
    """Draw a fleet of which so many robots age, and in which one tracker may drift."""
    rng = np.random.default_rng([seed, 16])
    of = draw_type(rng)
    worn = dict(zip(rng.permutation(robots)[:ageing].tolist(), _some(AGEING, ageing, rng), strict=True))
    each = tuple(draw_robot(of, k, rng, worn.get(k)) for k in range(robots))
    tracker = TRACKERS[int(rng.integers(2))]
    return FleetTruth(seed, each, tracker if drifting else None)


def draw_new(seed: int, count: int) -> tuple[RobotTruth, ...]:
    """Draw further robots of the type of a fleet."""
    of = draw_type(np.random.default_rng([seed, 16]))
    rng = np.random.default_rng([seed, 17])
    return tuple(draw_robot(of, 100 + k, rng) for k in range(count))


def identified_fleet(fleet: FleetTruth, configurations: int) -> list[FleetCampaign]:
    """Return what a campaign of every robot in every month tells; each meets both trackers in turn."""
    each = (
        record_robot(robot, month, TRACKERS[(robot.number + month) % 2], fleet, configurations)
        for robot in fleet.robots
        for month in range(MONTHS + 1)
    )
    return [FleetCampaign(one.robot, one.instrument, one.day, information_of(one.campaign)) for one in each]


def record_robot(
    robot: RobotTruth, month: int, tracker: str, fleet: FleetTruth, configurations: int
) -> Recorded:
    """Record one campaign."""
    share = month / MONTHS
    scale = SCALE_DRIFT * share if tracker == fleet.drifting else 0.0
    seed = int(np.random.SeedSequence([fleet.seed, robot.number, month]).generate_state(1)[0])
    cell = Cell(robot.scenario(share, scale), seed, CellClock(0))
    wishes = RecordingRequest(configurations=configurations, validation=0, attachments=1)
    return Recorded(name(robot.number), tracker, DAYS_A_MONTH * month, campaign_of(cell, wishes))


def new_cell(robot: RobotTruth, seed: int) -> Cell:
    """Return the cell of a further robot of a fleet, in which nothing has aged."""
    own = int(np.random.SeedSequence([seed, robot.number]).generate_state(1)[0])
    return Cell(robot.scenario(0.0, 0.0), own, CellClock(0))


def campaign_of(cell: Cell, wishes: RecordingRequest) -> Campaign:
    """Return the campaign of a cell, read back from its files."""
    return read_back(record_in(cell, wishes)[0])


def unseen(robot: RobotTruth, seed: int, count: int) -> tuple[Stops, np.ndarray, FloatArray]:
    """Return stops at other configurations, the nests there, and where they truly are, (n, 3)."""
    cell = Cell(robot.scenario(1.0, 0.0), seed, CellClock(0))
    wishes = RecordingRequest(configurations=count, validation=0, attachments=1)
    stops = plan_stops(cell, wishes, np.random.default_rng([seed, 77]))
    joints = np.radians(stops.joints_deg)
    conditions = cell.conditions(joints, stops.direction, stops.time_s, stops.attachment)
    true = cell.true_positions(conditions)[np.arange(count), stops.nest - 1]
    told = Stops(np.arange(1, count + 1), joints, stops.direction.astype(np.int64))
    return told, stops.nest.astype(np.int64), true


def _wave(order: float, phase_deg: float) -> dict[str, object]:
    return {"order": order, "phase_deg": phase_deg}


def _varied(rng: np.random.Generator, n: int) -> FloatArray:
    return 1.0 + _VARIED * rng.standard_normal(n)


def _some(cases: Sequence[Ageing], n: int, rng: np.random.Generator) -> list[Ageing]:
    return [cases[k] for k in rng.permutation(len(cases))[:n].tolist()]


def _grown(ageing: Ageing, share: float) -> PlantedChange:
    details = _wave(ageing.order, 40.0) if ageing.order else {}
    return PlantedChange(ageing.effect, ageing.subject, share * ageing.amplitude, details=details)
