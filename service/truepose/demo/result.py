"""What the demo says: `result.json` for programs, tables for people."""

from pathlib import Path
from typing import Final

from rich.console import Console
from rich.table import Table

from truepose.demo.cell.run import CAMPAIGN_FOLDER, MODEL_FILE, CellRun
from truepose.demo.diagnosis import diagnosis_lines
from truepose.demo.truth_comparison import JudgedRun, TrueErrors
from truepose.exchange.json_text import Json, number_or_null, render_json
from truepose.exchange.results.statistics import statistics_document
from truepose.reports.terminal.identification import figures_table, truth_table
from truepose.reports.wording.rounding import millimetres
from truepose.reports.wording.turns import turns_table
from truepose.version import __version__
from truepose.words.catalogue import english

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
    console.print(figures_table(judged.identification))
    turns = turns_table(judged.identification)
    if turns is not None:
        console.print(turns)
    if judged.errors is None:
        console.print(english(judged.identification.message), soft_wrap=True, markup=False)
    else:
        console.print(_errors_table(judged.errors))
        console.print(truth_table(judged.parameters))
    for line in diagnosis_lines(judged.run.diagnosis["document"]):
        console.print(line, soft_wrap=True, markup=False)
    console.print(
        f"{_verdict(judged.run)} Reports, result, campaign and model are in {out}.",
        soft_wrap=True,
        markup=False,
    )


def _errors_table(errors: TrueErrors) -> Table:
    table = Table(title="True errors of the identified model, mm: the simulator's knowledge")
    table.add_column("at the validation configurations")
    for name in ("n", "mean", "rms", "max"):
        table.add_column(name, justify="right")
    for label, figures in (("absolute", errors.absolute), ("after rigid alignment", errors.aligned)):
        values = (figures.mean_mm, figures.rms_mm, figures.max_mm)
        table.add_row(label, str(figures.n), *(millimetres(value) for value in values))
    return table


def _verdict(run: CellRun) -> str:
    if run.passed:
        return "Identified and validated."
    if run.validation is None:
        return "No model was identified."
    return "The model was not validated." if run.converged else "The identification did not converge."
