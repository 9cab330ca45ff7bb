"""The ballbar report: the ballbar beside a tracker and beside the thesis' procedure, and its own figures.

`python -m tests.studies.ballbar_report --out out/ballbar` (or `make ballbar-report`) plans sessions on a
Fanuc LR Mate 200iC, records them on simulated robots, identifies each robot by every instrument and judges
the models by the simulator's truth. It writes `report.html` and `report.json`.
"""

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from tests.studies.ballbar_report.connection_section import connection_section
from tests.studies.ballbar_report.connections import SlipCounts
from tests.studies.ballbar_report.document import ballbar_document
from tests.studies.ballbar_report.pose_device_figures import pose_device_section
from tests.studies.ballbar_report.robot_sections import robot_sections, stated_section
from tests.studies.ballbar_report.robots import Outcome
from tests.studies.ballbar_report.work import Extent, make_plans, outcomes_of, robots_of, slips_of
from tests.studies.diagnosis_report.workers import worker_processes
from tests.studies.report_command import add_sections, count, shown, status_of
from truepose.demo.progress import progress_bar
from truepose.exchange.json_text import render_json
from truepose.reports.table_report import Section, write_table_report

_QUICK: Final = Extent(robots=2, validation=300, stops=50, draws=20000)
_SECTIONS: Final = ("pose-device", "connections", "robots")


@dataclass(slots=True)
class _Measured:
    """What the rows were made from."""

    outcomes: list[Outcome] = field(default_factory=list)
    slips: SlipCounts | None = None


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure everything, print it, write it; status 1 where a target is missed."""
    options = _options(arguments)
    extent = _extent(options)
    measured = _Measured()
    sections = shown(_sections(options, extent, measured))
    _write(options.out, extent, sections, measured)
    return status_of(sections)


def _sections(options: argparse.Namespace, extent: Extent, measured: _Measured) -> Iterator[Section]:
    plans = options.plans or options.out / "plans"
    with progress_bar() as progress, worker_processes(options.jobs) as workers:
        if "pose-device" in options.sections:
            with progress.phase("pose device"):
                section = pose_device_section(extent.draws, extent.first_seed)
            yield section
        if "connections" in options.sections:
            with progress.phase(f"wrong connections at {extent.stops} stops") as told:
                measured.slips = slips_of(extent, workers, told)
            yield connection_section(measured.slips)
        if "robots" in options.sections:
            with progress.phase("plans") as told:
                make_plans(plans, workers, told)
            robots = robots_of(extent, plans)
            with progress.phase(f"{len(robots)} sessions") as told:
                measured.outcomes += outcomes_of(robots, workers, told)
            yield from robot_sections(measured.outcomes)
            yield stated_section(measured.outcomes)


def _write(out: Path, extent: Extent, sections: Sequence[Section], measured: _Measured) -> None:
    out.mkdir(parents=True, exist_ok=True)
    write_table_report(out / "report.html", "Ballbar report", sections, simulated=True)
    document = render_json(ballbar_document(extent, sections, measured.outcomes, measured.slips))
    (out / "report.json").write_text(document + "\n", encoding="utf-8")


def _extent(options: argparse.Namespace) -> Extent:
    if options.quick:
        return _QUICK
    return Extent(options.robots, options.validation, options.stops, options.draws, options.first_seed)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    usual = Extent()
    parser = argparse.ArgumentParser(
        prog="python -m tests.studies.ballbar_report",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="example: python -m tests.studies.ballbar_report --sections robots --robots 6",
    )
    add = parser.add_argument
    add("--out", type=Path, default=Path("out/ballbar"), help="default: %(default)s")
    add(
        "--plans", type=Path, help="folder of plans; used where there are, made where not (default: in --out)"
    )
    add("--robots", type=count, default=usual.robots, help="of each scenario (default: %(default)s)")
    add("--validation", type=count, default=usual.validation, help="positions of each (default: %(default)s)")
    add("--stops", type=count, default=usual.stops, help="with wrong connections (default: %(default)s)")
    add("--draws", type=count, default=usual.draws, help="of the twelve lengths (default: %(default)s)")
    add("--first-seed", type=count, default=usual.first_seed, help="default: %(default)s")
    add("--jobs", type=count, default=os.cpu_count() or 1, help="processes (default: one a core)")
    add_sections(parser, _SECTIONS)
    add("--quick", action="store_true", help="two robots of each kind: does it work at all?")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
