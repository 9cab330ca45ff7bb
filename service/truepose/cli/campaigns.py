"""Commands on campaign folders, model files and point files. Heavy imports wait until a command runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import (
    AcceptEdited,
    CampaignPath,
    Effects,
    Json,
    Language,
    MaxShiftMm,
    ModelFile,
    ReportFile,
    effect_names,
    read_measured,
    require_folders,
    writing,
)
from truepose.cli.models import checked_model, write_found
from truepose.cli.output import print_json, print_lines, print_tables, remark
from truepose.cli.set_aside import Person, SetAside, SetAsideFile, set_aside_line, without_set_aside
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, Catalogue, catalogue
from truepose.messages.message import Message, message

if TYPE_CHECKING:
    from truepose.domain.campaign import Campaign
    from truepose.domain.identification import Identification
    from truepose.exchange.json_text import Json as JsonValue
    from truepose.identification.problem.build import JointPrior


def identify_command(
    campaign: CampaignPath,
    effects: Effects = "auto",
    fleet: Annotated[
        Path | None,
        typer.Option(help="Prior from robots of the same type (written by `truepose fleet --pooled`)."),
    ] = None,
    model_out: Annotated[Path | None, typer.Option(help="Write the identified model here (JSON).")] = None,
    report: ReportFile = None,
    set_aside: SetAside = None,
    set_aside_file: SetAsideFile = None,
    person: Person = "",
    compare_thesis: Annotated[
        bool,
        typer.Option(
            "--compare-thesis",
            help="Ballbar campaigns: also identify from positions computed from six lengths each.",
        ),
    ] = False,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Identify the robot of a campaign folder.

    Example: truepose identify my-campaign --model-out robot.json --json
    """
    from truepose.identification import identify

    require_folders(model_out, report)
    words = catalogue(language)
    measured = read_measured(campaign)
    remark(map(words.spoken, measured.ignored))
    measured = without_set_aside(measured, set_aside, set_aside_file, person)
    believed = None if fleet is None else _believed(fleet, measured)
    answer = identify(measured, effect_names(effects), believed=believed)
    # Files first: who reads "converged" may rely on the model being there.
    if model_out is not None:
        write_found(answer.model if _converged(answer) else None, model_out, answer.message, words)
    if report is not None:
        _write_report(report, measured, answer, words)
    thesis = _as_thesis(measured) if compare_thesis else None
    if json:
        from truepose.exchange.results.identification import identification_document

        document = identification_document(answer, measured.robot.name)
        print_json(document if thesis is None else document | {"thesis_procedure": thesis[0]})
    else:
        _show(answer, words)
        remark(() if thesis is None else (words.spoken(thesis[1]),))
    return 0 if _converged(answer) else 1


def _believed(file: Path, campaign: "Campaign") -> "JointPrior":
    from truepose.exchange.models.file import read_pooled

    pooled = read_pooled(file)
    if pooled.robot != campaign.robot.name:
        raise ConfigurationError(
            f"{file.name} is for robots of type {pooled.robot}, but the campaign is of a "
            f"{campaign.robot.name}. Give the file for that type."
        )
    return pooled.belief


def _as_thesis(campaign: "Campaign") -> "tuple[dict[str, JsonValue], Message]":
    """Return what the procedure of the thesis gives, or why none of it: as a document, and in words."""
    from truepose.exchange.results.identification import identification_document
    from truepose.identification.thesis_procedure import identify_as_thesis

    try:
        answer, positions = identify_as_thesis(campaign)
    except ConfigurationError as error:
        why = str(error)
        return {"status": "not_possible", "message": why}, message("terminal.thesis", message=why)
    document = identification_document(answer, campaign.robot.name)
    return document | {"configurations_lost": list(positions.lost)}, _thesis_sentence(answer)


def _thesis_sentence(answer: "Identification") -> Message:
    judged = answer.positions.tied if answer.positions else None
    if judged is None:
        return message("terminal.thesis", message=answer.message)
    mean_mm = judged.identified.mean_mm
    return message("terminal.thesis.judged", mean_mm=mean_mm, message=answer.message)


def _converged(answer: "Identification") -> bool:
    return answer.model is not None and answer.status.value == "converged"


def _show(answer: "Identification", words: Catalogue) -> None:
    from truepose.reports.identification.summary import identification_summary

    print_tables(identification_summary(answer, words))
    print_lines(set_aside_line(answer.set_aside, words))


def _write_report(path: Path, campaign: "Campaign", answer: "Identification", words: Catalogue) -> None:
    from truepose.reports.identification.report import IdentificationReport

    IdentificationReport(answer, campaign, language=words.language).write(path)


def predict_command(
    model: ModelFile,
    points: Annotated[Path, typer.Argument(help="Rows of config, q1_deg.. and any other known columns.")],
    out: Annotated[Path, typer.Option(help="File for the predictions (CSV).")],
    max_shift_mm: MaxShiftMm = None,
    accept_edited: AcceptEdited = False,
    language: Language = ENGLISH,
) -> int:
    """Predict where the nests are.

    Example: truepose predict robot.json points.csv --out predicted.csv
    """
    from truepose.exchange.import_wizard.single_table import read_points_to_predict
    from truepose.exchange.tables.files import write_predictions
    from truepose.identification import predict
    from truepose.validation.cautions import prediction_cautions

    require_folders(out)
    words = catalogue(language)
    identified = checked_model(
        model, max_shift_mm, words, accept_edited=accept_edited, robot_follows=False
    ).model
    nests = [nest.nest for nest in identified.nests]
    rows = read_points_to_predict(points, identified.robot.n_joints, nests)
    remark(map(words.spoken, rows.ignored))
    stops, nest = rows.of_each_nest(nests)
    position, uncertainty = predict(identified, stops, nest)
    remark(map(words.spoken, prediction_cautions(identified, rows.stops)))
    with writing(out):
        write_predictions(out, stops.config, nest, position, uncertainty)
    return 0
