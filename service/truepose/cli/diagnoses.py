"""The command that says what a model gets wrong. Heavy imports wait until it runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import (
    CampaignPath,
    Json,
    Language,
    ReportFile,
    effect_names,
    read_measured,
    require_folders,
)
from truepose.cli.models import write_found
from truepose.cli.output import print_json, print_lines, print_tables, progress_bar, remark
from truepose.cli.set_aside import Person, SetAside, SetAsideFile, set_aside_line, without_set_aside
from truepose.messages.catalogue import ENGLISH, Catalogue, catalogue

if TYPE_CHECKING:
    from truepose.domain.campaign import Campaign
    from truepose.domain.diagnosis import Diagnosis


def diagnose_command(
    campaign: CampaignPath,
    effects: Annotated[
        str,
        typer.Option(
            help="Effects included in the initial model, comma-separated; these are not reported as "
            "findings. `auto`: base,tool,geometry,compliance."
        ),
    ] = "auto",
    model_out: Annotated[Path | None, typer.Option(help="Write the extended model here (JSON).")] = None,
    report: ReportFile = None,
    set_aside: SetAside = None,
    set_aside_file: SetAsideFile = None,
    person: Person = "",
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Find errors that the robot's model does not explain, name their causes, and measure the improvement.

    Status 1: nothing could be fitted, so there is no answer.

    Example: truepose diagnose my-campaign --model-out extended.json --report diagnosis.html
    """
    require_folders(model_out, report)
    names, words = effect_names(effects), catalogue(language)
    _check_known(names)
    measured = read_measured(campaign)
    remark(map(words.spoken, measured.ignored))
    measured = without_set_aside(measured, set_aside, set_aside_file, person)
    answer = _diagnosed(measured, names)
    # Files first: who reads "explained" may rely on the model being there.
    if model_out is not None:
        write_found(answer.model, model_out, answer.message, words)
    if report is not None:
        _write_report(report, _named(campaign, measured, words), measured, answer, words)
    _print(answer, words, as_json=json)
    return 0 if answer.model is not None else 1


def _check_known(names: tuple[str, ...] | None) -> None:
    """Refuse a misspelt or doubled effect before a large campaign is read; raises TrueposeError."""
    from truepose.effects.registry import chosen_effects

    chosen_effects(names or ())


def _diagnosed(campaign: "Campaign", effects: tuple[str, ...] | None) -> "Diagnosis":
    from truepose.diagnosis.diagnose import diagnose

    with progress_bar() as told:
        return diagnose(campaign, effects, told)


def _named(campaign: Path, measured: "Campaign", words: Catalogue) -> str:
    """Return what the readings are called: their folder, and their day."""
    day = measured.measured_on
    told = words.say("measured.unknown") if day is None else words.say("measured.on", day=str(day))
    return f"{campaign.resolve().name}, {told}"


def _write_report(
    path: Path, named: str, measured: "Campaign", answer: "Diagnosis", words: Catalogue
) -> None:
    from truepose.reports.diagnosis.report import DiagnosisReport
    from truepose.reports.traceability import ReportConditions

    conditions = ReportConditions(simulated=bool(measured.simulated))
    DiagnosisReport(answer, named, conditions=conditions, language=words.language).write(path)


def _print(answer: "Diagnosis", words: Catalogue, *, as_json: bool) -> None:
    if as_json:
        from truepose.exchange.results.diagnosis import diagnosis_document

        print_json(diagnosis_document(answer))
        return
    from truepose.cli.diagnosis_text import diagnosis_lines, errors_on_terminal

    print_lines(diagnosis_lines(answer, words))
    table = errors_on_terminal(answer, words)
    if table is not None:
        print_tables(table)
    print_lines(set_aside_line(answer.set_aside, words))
