"""Commands on campaign folders, model files and point files. Heavy imports wait until a command runs."""

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.output import print_json, print_tables, remark
from service.domain.errors import ConfigurationError

if TYPE_CHECKING:
    from service.domain.campaign import Campaign
    from service.domain.results import Identification, Model

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]


def identify_command(
    campaign: Annotated[Path, typer.Argument(help="Campaign folder, or a zip of one.")],
    effects: Annotated[
        str, typer.Option(help="`auto`, or names separated by commas, e.g. base,tool,geometry.")
    ] = "auto",
    model_out: Annotated[Path | None, typer.Option(help="Write the identified model here (JSON).")] = None,
    report: Annotated[Path | None, typer.Option(help="Write a self-contained HTML report here.")] = None,
    json: Json = False,
) -> int:
    """Identify the robot of a campaign folder.

    Example: truepose identify my-campaign --model-out robot.json --json
    """
    from service.exchange.result_documents import identification_document
    from service.identification import identify

    _require_folders(model_out, report)
    measured = _read(campaign)
    remark(measured.ignored)
    answer = identify(measured, _effect_names(effects))
    # Files first: who reads "converged" may rely on the model being there.
    if model_out is not None:
        _write_model(model_out, answer)
    if report is not None:
        _write_report(report, measured, answer)
    if json:
        print_json(identification_document(answer, measured.robot.name))
    else:
        _show(answer)
    return 0 if _converged(answer) else 1


def _effect_names(effects: str) -> tuple[str, ...] | None:
    if effects.strip() == "auto":
        return None
    names = tuple(name.strip() for name in effects.split(",") if name.strip())
    if not names:
        raise ConfigurationError(
            "--effects names no effect: give `auto`, or names separated by commas, e.g. base,geometry."
        )
    return names


def _require_folders(*files: Path | None) -> None:
    """Refuse before the work is done what could not be written after it."""
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise ConfigurationError(f"{file}: there is no folder {file.parent}; make it first.")
        if file is not None and file.is_dir():
            raise ConfigurationError(f"{file} is a folder: name a file in it.")


@contextlib.contextmanager
def _writing(file: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise ConfigurationError(
            f"{file} cannot be written ({error.strerror}); choose another file."
        ) from error


def _converged(answer: "Identification") -> bool:
    return answer.model is not None and answer.status.value == "converged"


def _write_model(path: Path, answer: "Identification") -> None:
    from service.exchange.model_file import write_model

    if answer.model is not None and _converged(answer):
        with _writing(path):
            write_model(answer.model, path)
    else:
        remark([f"No model was written to {path}: {answer.message}"])


def _read(path: Path) -> "Campaign":
    from service.exchange.campaign_folder import read_campaign
    from service.exchange.campaign_zip import read_campaign_zip

    if path.is_file() and path.suffix == ".zip":
        return read_campaign_zip(path.read_bytes(), path.name)
    return read_campaign(path)


def _show(answer: "Identification") -> None:
    from service.reports.summary import identification_summary

    print_tables(identification_summary(answer))


def _write_report(path: Path, campaign: "Campaign", answer: "Identification") -> None:
    from service.reports import ReportInput, write_identification_report

    write_identification_report(path, ReportInput(identification=answer, campaign=campaign))


def predict_command(
    model: Annotated[Path, typer.Argument(help="Model file written by `identify --model-out`.")],
    points: Annotated[Path, typer.Argument(help="Rows of config, q1_deg.. and what else is known.")],
    out: Annotated[Path, typer.Option(help="Where the predictions go (CSV).")],
) -> int:
    """Predict where the nests are.

    Example: truepose predict robot.json points.csv --out predicted.csv
    """
    import numpy as np

    from service.exchange.model_file import read_model
    from service.exchange.point_files import read_points_to_predict, write_predictions
    from service.identification import predict
    from service.identification.rows import each_nest

    _require_folders(out)
    identified = read_model(model)
    nests = [nest.nest for nest in identified.nests]
    rows = read_points_to_predict(points, identified.robot.n_joints, nests)
    remark(rows.ignored)
    stops, nest = (rows.stops, rows.nest) if rows.nest is not None else each_nest(rows.stops, np.array(nests))
    position, uncertainty = predict(identified, stops, nest)
    with _writing(out):
        write_predictions(out, stops.config, nest, position, uncertainty)
    return 0


def validate_command(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    points: Annotated[Path, typer.Argument(help="Measured rows that the model was not made from.")],
    limit_mm: Annotated[float | None, typer.Option(help="Largest error that passes.")] = None,
    json: Json = False,
) -> int:
    """Judge a model on readings it was not made from; status 1 when it fails.

    Example: truepose validate robot.json validation.csv --limit-mm 0.2 --json
    """
    from service.exchange.model_file import read_model
    from service.exchange.point_files import read_validation_file
    from service.exchange.result_documents import validation_document
    from service.validation import validate

    if limit_mm is not None and not 0.0 < limit_mm < math.inf:
        raise ConfigurationError(f"--limit-mm {limit_mm:g}: give the largest error that passes, above 0 mm.")
    identified: Model = read_model(model)
    measured = read_validation_file(
        points, identified.robot.n_joints, [nest.nest for nest in identified.nests]
    )
    remark(measured.ignored)
    answer = validate(identified, measured.readings, limit_mm=limit_mm)
    if json:
        print_json(validation_document(answer))
    else:
        from service.reports.summary import validation_summary

        print_tables(validation_summary(answer))
    return 0 if answer.passed else 1
