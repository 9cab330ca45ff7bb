"""The power report: which effects the diagnosis finds, at which amplitude, with how many readings.

`python -m tests.studies.diagnosis_report --out out/diagnosis` (or `make diagnosis-report`) hides effects
in simulated campaigns and counts what is found, missed and named wrongly, and writes `report.html` and
`report.json`. Figures on measured data need the folder that the environment variable TRUEPOSE_DATA names.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.studies.diagnosis_report.document import report_document
from tests.studies.diagnosis_report.joint_curves import joint_curves_section
from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.planted.measured_data import measured_section
from tests.studies.diagnosis_report.studies import studies
from tests.studies.diagnosis_report.study import Extent, Study
from tests.studies.diagnosis_report.timing import timing_section
from tests.studies.diagnosis_report.workers import outcomes_of
from tests.studies.report_command import add_sections, count, shown, status_of
from truepose.analysis.parallel.local_pool import workers
from truepose.demo.progress import RunProgress, progress_bar
from truepose.exchange.json_text import render_json
from truepose.reports.table_report import Section, write_table_report

_QUICK = Extent(campaigns=2, undisturbed=8, pairs=6, sizes=(100,))
_MEASURED, _TIMING, _CURVES = "measured", "timing", "curves"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure everything, print it, write it; status 1 where a target is missed."""
    options = _options(arguments)
    extent = _QUICK if options.quick else _extent(options)
    outcomes: dict[str, list[Outcome]] = {}
    sections = shown(_sections(options, studies(extent), outcomes))
    _write(options.out, extent, sections, outcomes)
    return status_of(sections)


def _sections(
    options: argparse.Namespace, every: tuple[Study, ...], outcomes: dict[str, list[Outcome]]
) -> Iterator[Section]:
    chosen = options.sections
    with progress_bar() as progress:
        if _TIMING in chosen:
            with progress.phase("time of one diagnosis"):
                section = timing_section()
            yield section
        if _MEASURED in chosen:
            with progress.phase("measured data"):
                section = measured_section()
            yield section
        if _CURVES in chosen:
            with progress.phase("joints off by curves"):
                section = joint_curves_section(options.first_seed)
            yield section
        yield from _simulated(options.workers, [s for s in every if s.key in chosen], outcomes, progress)


def _simulated(
    where: str | None, chosen: Sequence[Study], outcomes: dict[str, list[Outcome]], progress: RunProgress
) -> Iterator[Section]:
    with workers(where, sum(len(study.trials) for study in chosen)) as cluster:
        for study in chosen:
            with progress.phase(f"{study.title}: {len(study.trials)} diagnoses") as told:
                outcomes[study.key] = outcomes_of(study.trials, cluster, told)
            yield Section(study.title, study.rows(outcomes[study.key]), study.note(outcomes[study.key]))


def _write(
    out: Path, extent: Extent, sections: Sequence[Section], outcomes: dict[str, list[Outcome]]
) -> None:
    out.mkdir(parents=True, exist_ok=True)
    write_table_report(out / "report.html", "Power report of the diagnosis", sections, simulated=True)
    document = render_json(report_document(extent, sections, outcomes))
    (out / "report.json").write_text(document + "\n", encoding="utf-8")


def _extent(options: argparse.Namespace) -> Extent:
    return Extent(options.campaigns, options.undisturbed, options.pairs, options.sizes, options.first_seed)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    usual = Extent()
    keys = (_TIMING, _MEASURED, _CURVES, *(study.key for study in studies(_QUICK)))
    parser = argparse.ArgumentParser(
        prog="python -m tests.studies.diagnosis_report",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="example: python -m tests.studies.diagnosis_report --sections power --campaigns 4",
    )
    add = parser.add_argument
    add("--out", type=Path, default=Path("out/diagnosis"), help="default: %(default)s")
    add("--campaigns", type=count, default=usual.campaigns, help="a cell of the table (default: %(default)s)")
    add("--undisturbed", type=count, default=usual.undisturbed, help="without any effect, per size and noise")
    add("--pairs", type=count, default=usual.pairs, help="of effects (default: %(default)s)")
    add("--sizes", type=_sizes, default=usual.sizes, help="readings of a campaign (default: 50,100,200)")
    add("--first-seed", type=count, default=usual.first_seed, help="default: %(default)s")
    add("--workers", help="a number of processes, dask, or dask://host:port (default: one a core)")
    add_sections(parser, keys)
    add("--quick", action="store_true", help="a few campaigns of 100 readings: does it work at all?")
    return parser.parse_args(arguments)


def _sizes(text: str) -> tuple[int, ...]:
    try:
        return tuple(sorted({count(size) for size in text.split(",")}))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'"{text}" must be a number of readings, or several: 50,100'
        ) from None


if __name__ == "__main__":
    sys.exit(main())
