"""Fleets unlike those that the comparison was made with, and what is right to say of each."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tests.studies.fleet.beside.visits import DAYS_A_MONTH, Robots, Visit, draw_robots
from truepose.domain.campaign import Campaign
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.scenarios.scenario import ConfiguredLink, Scenario

ROBOTS: Final = 10
MONTHS: Final = 6  # campaigns of a robot
_TRACKERS: Final = ("tracker A", "tracker B")
Twist = Callable[[int, int], dict[str, object]]  # what is otherwise with a robot in a month


@dataclass(frozen=True)
class Planted:
    """A change that is there: who, what, from which month on (0: from the first)."""

    of: str  # robot or tracker; empty: the type
    effects: frozenset[str]
    subject: str = ""  # empty: any
    kinds: frozenset[str] = frozenset({"linear"})
    month: int = 0
    days: float = 0.0  # after the first of that month


@dataclass(frozen=True)
class Case:
    """One fleet."""

    robots: Robots
    visits: list[Visit]
    planted: tuple[Planted, ...] = ()


def _monthly(
    twist: Twist = lambda robot, month: {}, robots: int = ROBOTS, months: int = MONTHS
) -> list[Visit]:
    return [
        Visit(**{  # type: ignore[arg-type]
            "robot": robot,
            "month": month,
            "tracker": _TRACKERS[(robot + month) % 2],
            **twist(robot, month),
        })
        for robot in range(robots)
        for month in range(months)
    ]


def _fleet(seed: int, visits: list[Visit], *planted: Planted, everyday: bool = True) -> Case:
    return Case(draw_robots(seed, ROBOTS + 2, everyday=everyday), visits, planted)


def _growing(effect: str, joint: int, amplitude: float, order: float = 0.0) -> PlantedChange:
    details = {"order": order, "phase_deg": 40.0} if order else {}
    return PlantedChange(effect, f"joint {joint}", amplitude, details=details)


def _scale(share: float) -> PlantedChange:
    return PlantedChange("instrument_scale", "tracker", share)


# Nothing changes


def clean(seed: int) -> Case:
    """As in the main study, fewer."""
    return _fleet(seed, _monthly(), everyday=False)


def everyday(seed: int) -> Case:
    """Bending, wrong masses, springs that are no lines, warm-up and a base that drifts in each campaign."""
    return _fleet(seed, _monthly())


def season(seed: int) -> Case:
    """The hall is 8 K warmer in summer: links of aluminium follow, and a little the tracker's lengths."""

    def twist(robot: int, month: int) -> dict[str, object]:
        warmer_k = 8.0 * np.sin(np.pi * month / (MONTHS - 1))
        air = PlantedChange(
            "thermal_growth", "links", 18e-6, -1e8, {"warm_up_k": warmer_k, "time_constant_s": 10.0}
        )
        return {"changes": (air, _scale(0.5e-6 * warmer_k))}

    return _fleet(seed, _monthly(twist), everyday=False)


def unequal(seed: int) -> Case:
    """Robots measured once or twice, months missing, two or three campaigns in one month."""
    rng = np.random.default_rng([seed, 41])
    visits = [visit for visit in _monthly() if rng.random() < 0.6 or visit.month == 0]
    visits = [visit for visit in visits if visit.robot > 1 or visit.month == 0]
    again = [replace(visits[k]) for k in rng.permutation(len(visits))[:5].tolist()]
    return _fleet(seed, [*visits, *again])


def other_campaigns(seed: int) -> Case:
    """Another tool every second month, 20 to 60 readings, other joint ranges, mounted by hand."""
    rng = np.random.default_rng([seed, 42])

    def tool(scenario: Scenario) -> Scenario:
        other = replace(
            scenario.tool,
            nests_mm=((0.0, 0.0, 60.0), (60.0, 40.0, 120.0), (-80.0, 0.0, 90.0)),
            mass_kg=1.2,
            centre_of_gravity_mm=(0.0, 10.0, 50.0),
        )
        return replace(scenario, tool=other)

    def twist(robot: int, month: int) -> dict[str, object]:
        more: dict[str, object] = {"cell": tool} if month % 2 else {}
        return {"configurations": int(rng.integers(20, 60)), **more}

    return _fleet(seed, _monthly(twist))


def noise(seed: int) -> Case:
    """Tracker noise twice what is stated in some campaigns, half in others, and heavy tails."""
    rng = np.random.default_rng([seed, 43])

    def stated(times: float) -> Callable[[Campaign], Campaign]:
        def written(campaign: Campaign) -> Campaign:
            points = campaign.calibration
            assert points is not None
            u_mm = times * points.standard_uncertainty_mm
            return replace(campaign, calibration=replace(points, standard_uncertainty_mm=u_mm))

        return written

    def tails(scenario: Scenario) -> Scenario:
        return replace(scenario, tracker=replace(scenario.tracker, noise_degrees_of_freedom=3.0))

    def twist(robot: int, month: int) -> dict[str, object]:
        return {"written": stated(float(rng.choice([0.4, 0.7, 1.0, 2.0]))), "cell": tails}

    return _fleet(seed, _monthly(twist), everyday=False)


# Service and collisions


def motor(seed: int) -> Case:
    """The motor of joint 3 of robot 4 is exchanged: its zero is off by 0.02 deg."""

    planted = Planted("robot 04", frozenset({"joint_offset"}), "joint 3", frozenset({"step"}), 3)
    case = _fleet(seed, _monthly(), planted)
    return replace(
        case, visits=[_turned(case.robots, visit, 4, 3, 3, np.radians(0.02)) for visit in case.visits]
    )


def _turned(robots: Robots, visit: Visit, robot: int, month: int, joint: int, angle: float) -> Visit:
    if visit.robot != robot or visit.month < month:
        return visit
    link = robots.each[robot].links[joint - 1]
    x, y, z = link.rotation_rad
    return replace(visit, links=(replace(link, rotation_rad=(x, y, z + angle)),))


def belt(seed: int) -> Case:
    """The belt of joint 5 of robot 2 is tightened: its gap falls by 0.01 deg, its spring by 40 %."""

    def twist(robot: int, month: int) -> dict[str, object]:
        if robot != 2 or month < 2:
            return {}
        return {"changes": (_growing("backlash", 5, 0.02), _growing("compliance", 5, 0.2e-6))}

    planted = Planted("robot 02", frozenset({"backlash", "compliance"}), "joint 5", frozenset({"step"}), 2)
    return _fleet(seed, _monthly(twist), planted)


def collision(seed: int) -> Case:
    """A collision bends link 4 of robot 6."""
    case = _fleet(
        seed,
        _monthly(),
        Planted(
            "robot 06",
            frozenset({"geometry", "joint_offset", "axis_parallelism"}),
            "",
            frozenset({"step"}),
            4,
        ),
    )
    return replace(case, visits=[_bent(case.robots, visit) for visit in case.visits])


def _bent(robots: Robots, visit: Visit) -> Visit:
    if visit.robot != 6 or visit.month < 4:
        return visit
    link = robots.each[6].links[3]
    (x, y, z), (u, v, w) = link.translation_mm, link.rotation_rad
    bent = ConfiguredLink(4, (x + 0.05, y, z + 0.04), (u + 2e-4, v - 1.5e-4, w), link.compliance_rad_per_n_mm)
    return replace(visit, links=(bent,))


# Ageing in time


def newest(seed: int) -> Case:
    """The gap of joint 4 of robot 3 opens between the last two visits."""

    def twist(robot: int, month: int) -> dict[str, object]:
        return {"changes": (_growing("backlash", 4, 0.03),)} if (robot, month) == (3, MONTHS - 1) else {}

    planted = Planted("robot 03", frozenset({"backlash"}), "joint 4", frozenset({"step"}), MONTHS - 1)
    return _fleet(seed, _monthly(twist), planted)


def midway(seed: int) -> Case:
    """The spring of joint 5 of robot 7 softens evenly from month 2 on."""

    def twist(robot: int, month: int) -> dict[str, object]:
        come = max(month - 2, 0) / (MONTHS - 3)
        return {"changes": (_growing("compliance", 5, 0.35e-6 * come),)} if robot == 7 and come else {}

    return _fleet(seed, _monthly(twist), Planted("robot 07", frozenset({"compliance"}), "joint 5", month=2))


def two_causes(seed: int) -> Case:
    """A spring softens and a gear line grows in one robot."""

    def twist(robot: int, month: int) -> dict[str, object]:
        come = month / (MONTHS - 1)
        if robot != 1 or not come:
            return {}
        grown = (_growing("compliance", 3, 0.1e-6 * come), _growing("joint_harmonics", 4, 0.03 * come, 2.0))
        return {"changes": grown}

    return _fleet(
        seed,
        _monthly(twist),
        Planted("robot 01", frozenset({"compliance"}), "joint 3"),
        Planted("robot 01", frozenset({"joint_harmonics"}), "joint 4"),
    )


def software(seed: int) -> Case:
    """A release of the controller changes the zero of joint 5 of all robots by 0.01 deg from month 3 on."""
    case = _fleet(
        seed,
        _monthly(),
        Planted("", frozenset({"joint_offset"}), "joint 5", frozenset({"step"}), 3),
    )
    visits = case.visits
    for robot in range(ROBOTS):
        visits = [_turned(case.robots, visit, robot, 3, 5, np.radians(0.01)) for visit in visits]
    return replace(case, visits=visits)


# Instruments


def three_trackers(seed: int) -> Case:
    """Of three trackers one comes back from its calibration with 15e-6 more, one drifts by 30e-6."""

    def twist(robot: int, month: int) -> dict[str, object]:
        tracker = "ABC"[(robot + month) % 3]
        share = {"A": 0.0, "B": 15e-6 * (month >= 3), "C": 30e-6 * month / (MONTHS - 1)}[tracker]
        return {"tracker": f"tracker {tracker}", "changes": (_scale(share),) if share else ()}

    scale = frozenset({"instrument_scale"})
    return _fleet(
        seed,
        _monthly(twist),
        Planted("tracker B", scale, "", frozenset({"step"}), 3),
        Planted("tracker C", scale),
        everyday=False,
    )


def own_tracker(seed: int) -> Case:
    """A tracker measures one robot alone, and drifts by 40e-6: tracker, or growth of the robot."""

    def twist(robot: int, month: int) -> dict[str, object]:
        if robot != 5:
            return {"tracker": "tracker A"}
        share = 40e-6 * month / (MONTHS - 1)
        return {"tracker": "tracker B", "changes": (_scale(share),) if share else ()}

    either = frozenset({"instrument_scale", "thermal_growth"})
    return _fleet(seed, _monthly(twist), Planted("tracker B|robot 05", either), everyday=False)


def nests_of_a_day(seed: int) -> Case:
    """On one day the nests of the tool were entered as somebody remeasured them, wrongly."""

    def tool(campaign: Campaign) -> Campaign:
        moved = (0.0, 0.05, 0.03)
        nests = tuple(
            nest if nest.centre_mm is None else replace(nest, centre_mm=tuple(np.add(nest.centre_mm, moved)))
            for nest in campaign.nests
        )
        return replace(campaign, nests=nests)

    def twist(robot: int, month: int) -> dict[str, object]:
        return {"written": tool} if month == 3 else {}

    return _fleet(seed, _monthly(twist), Planted("", frozenset({"any"}), "", frozenset({"day"}), 3))


# What was written down wrongly


def other_robot(seed: int) -> Case:
    """One campaign of robot 2 was of a robot that is none of the fleet."""

    def twist(robot: int, month: int) -> dict[str, object]:
        return {"truly": ROBOTS} if (robot, month) == (2, 3) else {}

    return _fleet(seed, _monthly(twist))


def mixed_up(seed: int) -> Case:
    """The serial numbers of two robots were exchanged on one day."""

    def twist(robot: int, month: int) -> dict[str, object]:
        return {"truly": 9 - robot} if robot in {4, 5} and month == 2 else {}

    return _fleet(seed, _monthly(twist))


def gross(seed: int) -> Case:
    """A reading is off by 2 mm in one campaign, a third of two nests is swapped in another."""

    def twist(robot: int, month: int) -> dict[str, object]:
        if (robot, month) == (3, 2):
            return {"changes": (PlantedChange("outliers", "readings", 0.05, details={"size_mm": 2.0}),)}
        if (robot, month) == (6, 4):
            return {"changes": (PlantedChange("label_swap", "nest 1, nest 2", 0.2),)}
        return {}

    return _fleet(seed, _monthly(twist))


def days_exchanged(seed: int) -> Case:
    """The days of an ageing robot's campaigns were entered in the wrong order."""

    def twist(robot: int, month: int) -> dict[str, object]:
        if robot != 8:
            return {}
        come = month / (MONTHS - 1)
        day = {1: 4, 4: 1}.get(month, month) * DAYS_A_MONTH
        return {"changes": (_growing("compliance", 5, 0.4e-6 * come),) if come else (), "day": day}

    return _fleet(
        seed,
        _monthly(twist),
        Planted("robot 08", frozenset({"compliance"}), "joint 5", frozenset({"linear", "step"})),
    )


def twice_a_day(seed: int) -> Case:
    """Every robot was measured in the morning and in the afternoon, by either tracker."""
    morning = _monthly(months=3)
    other = {"tracker A": "tracker B", "tracker B": "tracker A"}
    return _fleet(seed, [*morning, *(replace(visit, tracker=other[visit.tracker]) for visit in morning)])


def own_days(seed: int) -> Case:
    """Each robot has days of its own before one tracker; one ages, and the tracker drifts by 30e-6."""

    def twist(robot: int, month: int) -> dict[str, object]:
        come = month / (MONTHS - 1)
        day = month * DAYS_A_MONTH + 2.0 * robot
        grown = (_growing("compliance", 5, 0.4e-6 * come),) if robot == 4 else ()
        changes = (*grown, _scale(30e-6 * day / (5 * DAYS_A_MONTH))) if day else ()
        return {"tracker": "tracker A", "day": day, "changes": changes}

    return _fleet(
        seed,
        _monthly(twist),
        Planted("robot 04", frozenset({"compliance"}), "joint 5", days=2.0 * 4),
        Planted("tracker A|", frozenset({"instrument_scale", "thermal_growth"})),
        everyday=False,
    )


def few(seed: int) -> Case:
    """Six everyday robots, four campaigns of 25 readings each: of fewer than eight none tells the excess."""

    def twist(robot: int, month: int) -> dict[str, object]:
        return {"configurations": 25}

    return _fleet(seed, _monthly(twist, robots=6, months=4))


CASES: Final[dict[str, Callable[[int], Case]]] = {
    one.__name__: one
    for one in (
        clean,
        everyday,
        season,
        unequal,
        other_campaigns,
        noise,
        motor,
        belt,
        collision,
        newest,
        midway,
        two_causes,
        software,
        three_trackers,
        own_tracker,
        nests_of_a_day,
        other_robot,
        mixed_up,
        gross,
        days_exchanged,
        twice_a_day,
        own_days,
        few,
    )
}
