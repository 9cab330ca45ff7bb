"""`truepose nightly`: every scenario end to end on simulated devices, and a robot that goes wrong."""

import asyncio
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from truepose.demo.cell.run import run_cell
from truepose.demo.diagnosis import write_diagnosis
from truepose.demo.night.cases import Check, NightCase, night_cases
from truepose.demo.night.results import CaseOutcome, print_night, write_night
from truepose.demo.progress import RunProgress, shown_progress
from truepose.demo.report import REPORT, write_report
from truepose.demo.result import RESULT, write_result
from truepose.demo.truth_comparison import judge
from truepose.domain.errors import TrueposeError

_FAILED: Final = 1
_SERVICE_FAILED: Final = 3
_INTERRUPTED: Final = 130


def run_nightly(out: Path, seed: int, cases: Sequence[NightCase] | None = None) -> int:
    """Run all cases one after the other; leave junit.xml, report.html, result.json and their data in `out`.

    Parameters
    ----------
    out : Path
        Created where needed.
    seed : int
        Which cell of each kind.
    cases : sequence of NightCase, optional
        By default those of `night_cases`.

    Returns
    -------
    int
        Exit status: 0 every figure was reached, 1 one was not, 3 the service or a simulated cell failed,
        130 interrupted.
    """
    out.mkdir(parents=True, exist_ok=True)
    began_s = time.perf_counter()
    outcomes: list[CaseOutcome] = []
    with shown_progress() as progress:
        try:
            for case in night_cases(seed) if cases is None else cases:
                outcomes.append(_outcome(case, out / case.name, progress))
        except KeyboardInterrupt:
            progress.say(f"Interrupted while {progress.doing}; nothing is judged. {_kept(out)}")
            return _INTERRUPTED
    write_night(outcomes, seed, time.perf_counter() - began_s, out)
    print_night(outcomes, out)
    return _status(outcomes)


def _outcome(case: NightCase, folder: Path, progress: RunProgress) -> CaseOutcome:
    began_s = time.perf_counter()
    progress.chapter(case.name)
    try:
        checks = _run(case, folder, progress)
    except TrueposeError as error:
        progress.say(str(error))
        return CaseOutcome(case, [], str(error), time.perf_counter() - began_s)
    return CaseOutcome(case, checks, None, time.perf_counter() - began_s)


def _run(case: NightCase, folder: Path, progress: RunProgress) -> list[Check]:
    folder.mkdir(parents=True, exist_ok=True)
    began_s = time.perf_counter()
    run = asyncio.run(run_cell(case.request_in(folder), folder, progress))
    judged = judge(run)
    write_report(judged, folder / REPORT)
    write_diagnosis(run, folder)
    write_result(judged, time.perf_counter() - began_s, folder / RESULT)
    return case.checks(judged)


def _kept(out: Path) -> str:
    return f"What was measured until then is kept in the folders of {out}."


def _status(outcomes: Sequence[CaseOutcome]) -> int:
    if any(outcome.error is not None for outcome in outcomes):
        return _SERVICE_FAILED
    return 0 if all(check.passed for outcome in outcomes for check in outcome.checks) else _FAILED
