"""`truepose demo`: the main job without hardware, from the first motion to report and `result.json`."""

import asyncio
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from rich.console import Console

from truepose.demo.cell_run import CAMPAIGN_FOLDER, MODEL_FILE, CellRequest, CellRun, run_cell
from truepose.demo.errors import DemoError, UnusableScenarioError
from truepose.demo.processes import DATABASE
from truepose.demo.progress import RunProgress, progress_bar
from truepose.demo.report import REPORT, diagnosis_lines, write_diagnosis, write_report
from truepose.demo.truth_comparison import JudgedRun, TrueErrors, judge
from truepose.exchange.cells.file import reads_poses
from truepose.exchange.json_text import Json, number_or_null, render_json
from truepose.exchange.results.document import statistics_document
from truepose.messages.catalogue import IN_ENGLISH, english
from truepose.reports.error_tables import title_of, turns_table
from truepose.reports.identification.judged_figures import figures_table
from truepose.reports.identification.summary import truth_table
from truepose.reports.rounding import millimetres
from truepose.reports.tables import Table, on_terminal
from truepose.version import __version__

RESULT: Final = "result.json"


def write_result(judged: JudgedRun, wall_s: float, file: Path) -> None:
    """Write the document of a run; `truth` is null where nothing was identified."""
    run = judged.run
    document: dict[str, Json] = {
        "scenario": run.request.scenario,
        "seed": run.request.seed,
        "version": __version__,
        "identification": run.identification,
        "validation": run.validation,
        "diagnosis": run.diagnosis["document"],
        "truth": None if judged.errors is None else _truth(judged, judged.errors),
        "campaign": CAMPAIGN_FOLDER,
        "model": None if run.model is None else MODEL_FILE,
        "wall_s": round(wall_s, 3),
    }
    file.write_text(render_json(document) + "\n", encoding="utf-8")


def _truth(judged: JudgedRun, errors: TrueErrors) -> dict[str, Json]:
    return {
        "validation_true_error": statistics_document(errors.absolute),
        "validation_true_error_aligned": statistics_document(errors.aligned),
        "parameters": [
            {
                "name": parameter.name,
                "identified": parameter.identified,
                "true": number_or_null(parameter.true),
                "standard_uncertainty": parameter.standard_uncertainty,
                "unit": parameter.unit,
            }
            for parameter in judged.parameters
        ],
    }


def show_result(judged: JudgedRun, out: Path) -> None:
    """Print the tables on standard output."""
    console = Console(highlight=False)
    errors, turns = figures_table(judged.identification), turns_table(judged.identification)
    console.print(on_terminal(errors, IN_ENGLISH.say(title_of(judged.identification))))
    if turns.rows:
        console.print(on_terminal(turns, IN_ENGLISH.say("turns.title")))
    if judged.errors is None:
        console.print(english(judged.identification.message), soft_wrap=True, markup=False)
    else:
        title = "True errors of the identified model, mm (from the simulator)"
        console.print(on_terminal(_errors_table(judged.errors), title))
        console.print(on_terminal(truth_table(judged.parameters), IN_ENGLISH.say("terminal.truth")))
    for line in diagnosis_lines(judged.run.diagnosis["document"]):
        console.print(line, soft_wrap=True, markup=False)
    console.print(
        f"{_verdict(judged.run)} Reports, result, campaign and model are in {out}.",
        soft_wrap=True,
        markup=False,
    )


def _errors_table(errors: TrueErrors) -> Table:
    rows = []
    for label, figures in (("absolute", errors.absolute), ("after rigid alignment", errors.aligned)):
        values = (figures.mean_mm, figures.rms_mm, figures.max_mm)
        rows.append([label, str(figures.n), *map(millimetres, values)])
    return Table(("at the validation configurations", "n", "mean", "rms", "max"), rows, names=1)


def _verdict(run: CellRun) -> str:
    if run.passed:
        return "Identified and validated."
    if run.validation is None:
        return "No model was identified."
    return "The model failed validation." if run.converged else "The identification did not converge."


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
    with progress_bar() as progress:
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
    return f"the measurements so far are kept in {database}"
