"""New robots of a fleet by command: fifteen readings and the type against fifty alone, at unseen places.

`python -m tests.studies.fleet.by_command --fleets 2 --out out/new` writes the campaigns of forty robots in
six months, has `truepose fleet` compare them, measures new robots where its plan and `truepose plan` say, and
has `truepose identify` and `truepose validate` say how exact they are at places that were not measured.
"""

import argparse
import csv
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np

from tests.helpers.commands import typed
from tests.studies.fleet.archive import written_fleet
from tests.studies.fleet.simulated import RobotTruth, draw_new, new_cell
from tests.studies.promise.tracker import recorded_stops
from truepose.exchange.campaigns.folder import write_campaign
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.recording.campaign import record_at
from truepose_simulators.recording.files import points_table, write_table
from truepose_simulators.recording.plan import plan_stops

_UNSEEN: Final = 300
_ALONE: Final = 50
_OF_THE_FLEET: Final = "base,tool,geometry,compliance,joint_harmonics,backlash"


@dataclass(frozen=True, slots=True)
class NewRobot:
    """Mean errors of one new robot [mm] at unseen places, as `truepose validate` says them."""

    fleet: int
    robot: int
    pooled_mm: float
    alone_mm: float
    same_mm: float  # as many alone, by the effects of the fleet


def main() -> int:
    """Measure, print and write."""
    options = _options()
    found: list[NewRobot] = []
    promised = []
    for seed in range(options.first, options.first + options.fleets):
        folder = options.out / f"fleet-{seed}"
        if not (folder / "campaigns").is_dir():
            written_fleet(
                folder / "campaigns", seed, robots=options.robots, configurations=40, ageing=options.ageing
            )
        said = json.loads(
            _typed(
                "fleet",
                folder / "campaigns",
                "--out",
                folder / "told",
                "--workers",
                1,
                "--pooled",
                folder / "pooled.json",
                "--new",
                folder / "new.csv",
                "--json",
            )
        )
        promised.append(said["new_robot"])
        _typed("plan", "abb-irb-120", "--n", _ALONE, "--out", folder / "alone.csv")
        for robot in draw_new(seed, options.new):
            found.append(_new_robot(folder, seed, robot))
            sys.stderr.write(f"{found[-1]}\n")
            _write(options.out / "by_command.json", found, promised)
    sys.stdout.write(_told(found, promised))
    return 0


def _new_robot(folder: Path, seed: int, robot: RobotTruth) -> NewRobot:
    cell = new_cell(robot, seed)
    here = folder / f"new-{robot.number}"
    few, many = here / "few", here / "many"
    write_campaign(recorded_stops(cell, *_planned(folder / "new.csv")), few)
    write_campaign(recorded_stops(cell, *_planned(folder / "alone.csv")), many)
    unseen = _unseen(cell, here / "unseen.csv")
    return NewRobot(
        seed,
        robot.number,
        _mean_mm(here / "pooled.json", unseen, few, "--fleet", folder / "pooled.json"),
        _mean_mm(here / "alone.json", unseen, many),
        _mean_mm(here / "same.json", unseen, many, "--effects", _OF_THE_FLEET),
    )


def _planned(file: Path) -> tuple[np.ndarray, np.ndarray]:
    with file.open(encoding="utf-8") as opened:
        rows = list(csv.DictReader(opened))
    joints = np.radians([[float(row[f"q{k}_deg"]) for k in range(1, 7)] for row in rows])
    return joints, np.array([int(row["nest"]) for row in rows])


def _unseen(cell: Cell, file: Path) -> Path:
    """Write readings at configurations drawn by chance, approached from below as all others are."""
    wishes = RecordingRequest(configurations=1, validation=_UNSEEN, attachments=1, approach="from_below")
    stops = plan_stops(cell, wishes, np.random.default_rng([cell.seed, 78]))
    write_table(file, points_table(record_at(cell, stops, wishes)[0].validation))
    return file


def _mean_mm(model: Path, unseen: Path, campaign: Path, *options: str | Path) -> float:
    _typed("identify", campaign, "--model-out", model, *options)
    said = json.loads(_typed("validate", model, unseen, "--json"))
    return float(said["position"]["identified"]["mean_mm"])


def _typed(*arguments: str | int | Path) -> str:
    done = typed(*arguments)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stdout}{done.stderr}")
    return str(done.stdout)


def _write(file: Path, found: Sequence[NewRobot], promised: Sequence[object]) -> None:
    document = {"new_robots": [asdict(one) for one in found], "promised": promised}
    file.write_text(json.dumps(document, indent=1), encoding="utf-8")


def _told(found: Sequence[NewRobot], promised: Sequence[dict[str, float]]) -> str:
    pooled, alone, same = (
        1e3 * np.array([getattr(one, key) for one in found]) for key in ("pooled_mm", "alone_mm", "same_mm")
    )
    return (
        f"{len(found)} new robots, means at {_UNSEEN} unseen readings: {pooled.mean():.1f} um with 15 and the"
        f" type, {alone.mean():.1f} um with 50 alone (better in {np.sum(pooled <= alone)}), {same.mean():.1f}"
        f" um with 50 by the effects of the fleet (better in {np.sum(pooled <= same)})\n"
        f"promised: {json.dumps(list(promised))}\n"
    )


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--fleets", type=int, default=2)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--robots", type=int, default=40)
    parser.add_argument("--ageing", type=int, default=3, help="robots; a tracker drifts besides")
    parser.add_argument("--new", type=int, default=10, help="robots of each fleet")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
