"""`truepose demo`: the main job without hardware, from the first motion to the report."""

import asyncio
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.demo.cell.opened import DATABASE
from truepose.demo.cell.run import CellRequest, run_cell
from truepose.demo.diagnosis import write_diagnosis
from truepose.demo.errors import DemoError, UnusableScenarioError
from truepose.demo.progress import RunProgress, shown_progress
from truepose.demo.report import REPORT, write_report
from truepose.demo.result import RESULT, show_result, write_result
from truepose.demo.truth_comparison import JudgedRun, judge
from truepose.exchange.cells.file import reads_poses

_FAILED: Final = 1
_UNUSABLE_INPUT: Final = 2
_SERVICE_FAILED: Final = 3
_INTERRUPTED: Final = 130


@dataclass(frozen=True, slots=True)
class DemoSize:
    """How many configurations the demo measures; revisits come on top of the calibration."""

    calibration: int = 50
    validation: int = 1000


_OF_POSES: Final = DemoSize(36, 300)  # calibration as the thesis; a pose shows three nests to judge by


def run_demo(out: Path, seed: int, scenario: str, size: DemoSize | None = None) -> int:
    """Measure, identify, validate and diagnose a simulated robot; leave result.json and report.html in `out`.

    Parameters
    ----------
    out : Path
        Folder for results, campaign, model, database and log; created where needed. Readings of an
        earlier run stay in its database; everything else is replaced.
    seed : int
        Which cell of that kind.
    scenario : str
        Shipped name, or a scenario file whose name begins with that of its robot.
    size : DemoSize, optional

    Returns
    -------
    int
        Exit status: 0 identified and validated, 1 not, 2 no such scenario, 3 the service or the simulated
        cell failed, 130 interrupted.
    """
    out.mkdir(parents=True, exist_ok=True)
    amount = size or (_OF_POSES if reads_poses(scenario) else DemoSize())
    request = CellRequest(scenario, seed, amount.calibration, amount.validation)
    with shown_progress() as progress:
        try:
            judged = _run(request, out, progress)
        except DemoError as error:
            progress.say(str(error))
            return _UNUSABLE_INPUT if isinstance(error, UnusableScenarioError) else _SERVICE_FAILED
        except KeyboardInterrupt:
            progress.say(f"Interrupted while {progress.doing}; {_kept(out)}.")
            return _INTERRUPTED
    show_result(judged, out)
    return 0 if judged.run.passed else _FAILED


def _run(request: CellRequest, out: Path, progress: RunProgress) -> JudgedRun:
    began_s = time.perf_counter()
    run = asyncio.run(run_cell(request, out, progress))
    with progress.phase("comparing with the truth"):
        judged = judge(run)
    with progress.phase("writing the reports"):
        write_report(judged, out / REPORT)
        write_diagnosis(run, out)
    write_result(judged, time.perf_counter() - began_s, out / RESULT)
    return judged


def _kept(out: Path) -> str:
    database = out / DATABASE
    if not database.exists():
        return "nothing had been measured yet"
    return f"what was measured until then is kept in {database}"
