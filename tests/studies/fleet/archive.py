"""A small fleet as a folder of campaigns, for `truepose fleet`: who ages in it, and a new robot beside it.

`python -m tests.studies.fleet.archive --out out/fleet` writes, in a few seconds of one core, campaigns of
twelve simulated robots in six months. `--steady` writes them without any change.
"""

import json
import sys
from collections.abc import Iterable
from datetime import date, timedelta
from pathlib import Path

from tests.studies.fleet.simulated import (
    DAYS_A_MONTH,
    MONTHS,
    TRACKERS,
    FleetTruth,
    RobotTruth,
    draw_fleet,
    draw_new,
    record_robot,
)
from tests.studies.running import study_options
from truepose.exchange.campaigns.folder import write_campaign

FIRST = date(2026, 3, 2)


def main() -> int:
    """Write, and say what was planted."""
    options = study_options(
        __doc__,
        out=Path,
        seed=1,
        robots=12,
        configurations=(40, "of each campaign"),
        ageing=(2, "robots; a tracker drifts besides"),
        steady=(False, "nothing changes"),
    )
    fleet = written_fleet(
        options.out / "campaigns",
        options.seed,
        robots=options.robots,
        configurations=options.configurations,
        ageing=0 if options.steady else options.ageing,
    )
    new = draw_new(fleet.seed, 1)[0]
    for size in (15, 50):
        _write(fleet, new, 0, size, options.out / f"new-robot-{size}")
    for robot, worn in fleet.ageing.items():
        order = f", {worn.order:g} per turn" if worn.order else ""
        sys.stdout.write(f"planted: {robot}: {worn.effect}, joint {worn.joint}{order}\n")
    sys.stdout.write(f"planted: {fleet.drifting or 'no tracker'} drifts\n")
    return 0


def written_fleet(
    folder: Path,
    seed: int,
    *,
    robots: int,
    configurations: int,
    ageing: int,
    months: Iterable[int] = range(MONTHS + 1),
) -> FleetTruth:
    """Write a campaign of every robot in some months; with ageing robots one tracker drifts too."""
    fleet = draw_fleet(seed, robots, ageing=ageing, drifting=ageing > 0)
    for robot in fleet.robots:
        for month in months:
            _write(fleet, robot, month, configurations, folder / f"robot-{robot.number:02d}-month-{month}")
    return fleet


def _write(fleet: FleetTruth, robot: RobotTruth, month: int, configurations: int, folder: Path) -> None:
    tracker = TRACKERS[(robot.number + month) % 2]
    recorded = record_robot(robot, month, tracker, fleet, configurations)
    write_campaign(recorded.campaign, folder)
    _sign(folder / "campaign.json", recorded.robot, tracker, FIRST + timedelta(days=month * DAYS_A_MONTH))


def _sign(file: Path, robot: str, instrument: str, day: date) -> None:
    """Enter which robot was measured, by what and when."""
    document = json.loads(file.read_text(encoding="utf-8"))
    said = {
        "robot_serial_number": robot,
        "instrument_serial_number": instrument,
        "measured_on": day.isoformat(),
    }
    file.write_text(json.dumps(document | said, indent=1), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
