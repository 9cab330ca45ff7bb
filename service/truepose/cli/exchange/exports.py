"""The command that writes an identified model for other programs. Heavy imports wait until it runs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from truepose.cli.exchange.files import (
    AcceptEdited,
    Json,
    Language,
    MaxShiftMm,
    require_folders,
    writing,
)
from truepose.cli.exchange.models import checked_model
from truepose.cli.output import print_json, print_lines
from truepose.words.catalogue import ENGLISH, catalogue


class Form(StrEnum):
    """What a model is written as."""

    URDF = "urdf"
    ROS = "ros"
    DHM = "dhm"
    CONTROLLER = "controller"


def export_command(
    model: Annotated[Path, typer.Argument(help="Model file written by `identify --model-out`.")],
    out: Annotated[Path, typer.Option(help="The file to write; a table is CSV where it ends in .csv.")],
    form: Annotated[
        Form,
        typer.Option(
            "--as",
            help="URDF; calibrated_kinematics.yaml of ROS for Universal Robots; the DH-Modified table; "
            "joint zeros, base and tool for a controller.",
        ),
    ],
    fitted: Annotated[
        bool,
        typer.Option(
            "--fitted",
            help="Fit the table to the full model, so that what it lacks is in it as far as it can be.",
        ),
    ] = False,
    max_shift_mm: MaxShiftMm = None,
    accept_edited: AcceptEdited = False,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Write a model for another program, and say what is lost.

    Example: truepose export robot.json --as urdf --out robot.urdf
    """
    from truepose.exchange.exports.formats import export

    require_folders(out)
    words = catalogue(language)
    identified = checked_model(model, max_shift_mm, words, accept_edited=accept_edited).model
    exported = export(identified, form.value, fitted=fitted, as_csv=out.suffix.lower() == ".csv")
    with writing(out):
        exported.write(out)
    if json:
        from truepose.exchange.results.exports import export_document

        print_json(export_document(exported, identified.robot.name))
    else:
        print_lines(map(words.spoken, exported.remarks))
    return 0
