"""Commands on campaign folders, model files and point files. Heavy imports wait until a command runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import CampaignPath, Json, effect_names, read_measured, require_folders, writing
from truepose.cli.output import print_json, print_tables, remark
from truepose.domain.errors import ConfigurationError
from truepose.words.catalogue import english

if TYPE_CHECKING:
    from truepose.domain.campaign import Campaign
    from truepose.domain.results import Identification
    from truepose.exchange.json_text import Json as JsonValue


def identify_command(
    campaign: CampaignPath,
    effects: Annotated[
        str, typer.Option(help="`auto`, or names separated by commas, e.g. base,tool,geometry.")
    ] = "auto",
    model_out: Annotated[Path | None, typer.Option(help="Write the identified model here (JSON).")] = None,
    report: Annotated[Path | None, typer.Option(help="Write a self-contained HTML report here.")] = None,
    compare_thesis: Annotated[
        bool,
        typer.Option(
            "--compare-thesis",
            help="Of a ballbar campaign: also turn the legs into positions first, as the thesis does.",
        ),
    ] = False,
    json: Json = False,
) -> int:
    """Identify the robot of a campaign folder.

    Example: truepose identify my-campaign --model-out robot.json --json
    """
    from truepose.identification import identify

    require_folders(model_out, report)
    measured = read_measured(campaign)
    remark(measured.ignored)
    answer = identify(measured, effect_names(effects))
    # Files first: who reads "converged" may rely on the model being there.
    if model_out is not None:
        _write_model(model_out, answer)
    if report is not None:
        _write_report(report, measured, answer)
    thesis = _as_thesis(measured) if compare_thesis else None
    if json:
        from truepose.exchange.results.identification_and_validation import identification_document

        document = identification_document(answer, measured.robot.name)
        print_json(document if thesis is None else document | {"thesis_procedure": thesis})
    else:
        _show(answer)
        remark(_thesis_sentences(thesis))
    return 0 if _converged(answer) else 1


def _as_thesis(campaign: "Campaign") -> "dict[str, JsonValue]":
    """Return the document of the thesis' procedure; where it cannot be followed, why."""
    from truepose.exchange.results.identification_and_validation import identification_document
    from truepose.identification.thesis_procedure import identify_as_thesis

    try:
        answer, positions = identify_as_thesis(campaign)
    except ConfigurationError as error:
        return {"status": "not_possible", "message": str(error)}
    return {
        **identification_document(answer, campaign.robot.name),
        "configurations_lost": list(positions.lost),
    }


def _thesis_sentences(thesis: "dict[str, JsonValue] | None") -> list[str]:
    if thesis is None:
        return []
    statistics = thesis.get("statistics")
    judged = statistics.get("validation_position") if isinstance(statistics, dict) else None
    identified = judged.get("identified") if isinstance(judged, dict) else None
    error = f", mean position error {identified['mean_mm']:.3f} mm" if isinstance(identified, dict) else ""
    return [f"As the thesis does (positions from six legs each){error}: {thesis['message']}"]


def _converged(answer: "Identification") -> bool:
    return answer.model is not None and answer.status.value == "converged"


def _write_model(path: Path, answer: "Identification") -> None:
    from truepose.exchange.models.file import write_model

    if answer.model is not None and _converged(answer):
        with writing(path):
            write_model(answer.model, path)
    else:
        remark([f"No model was written to {path}: {english(answer.message)}"])


def _show(answer: "Identification") -> None:
    from truepose.reports.summary import identification_summary

    print_tables(identification_summary(answer))


def _write_report(path: Path, campaign: "Campaign", answer: "Identification") -> None:
    from truepose.reports import ReportInput, write_identification_report

    write_identification_report(path, ReportInput(identification=answer, campaign=campaign))


def predict_command(
    model: Annotated[Path, typer.Argument(help="Model file written by `identify --model-out`.")],
    points: Annotated[Path, typer.Argument(help="Rows of config, q1_deg.. and what else is known.")],
    out: Annotated[Path, typer.Option(help="Where the predictions go (CSV).")],
) -> int:
    """Predict where the nests are.

    Example: truepose predict robot.json points.csv --out predicted.csv
    """
    from truepose.exchange.models.file import read_model
    from truepose.exchange.tables.files import read_points_to_predict, write_predictions
    from truepose.identification import predict
    from truepose.judgement.cautions import prediction_cautions

    require_folders(out)
    identified = read_model(model)
    nests = [nest.nest for nest in identified.nests]
    rows = read_points_to_predict(points, identified.robot.n_joints, nests)
    remark(rows.ignored)
    stops, nest = rows.of_each_nest(nests)
    position, uncertainty = predict(identified, stops, nest)
    remark(map(english, prediction_cautions(identified, rows.stops)))
    with writing(out):
        write_predictions(out, stops.config, nest, position, uncertainty)
    return 0
