"""Model files as commands take them, and the command that writes one for other programs.

Heavy imports wait until it runs.
"""

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import (
    AcceptEdited,
    Json,
    Language,
    MaxShiftMm,
    ModelFile,
    require_folders,
    writing,
)
from truepose.cli.output import print_json, print_lines, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, Catalogue, catalogue
from truepose.messages.message import Text

if TYPE_CHECKING:
    from truepose.domain.identification import Model
    from truepose.exchange.models.acceptance import CheckedModel


def checked_model(
    file: Path,
    max_shift_mm: float | None,
    words: Catalogue,
    *,
    accept_edited: bool,
    robot_follows: bool = True,
) -> "CheckedModel":
    """Read a model file that is accepted and print what is remarkable on it; raises InputFileError."""
    from truepose.exchange.models.acceptance import Acceptance, read_checked_model

    if max_shift_mm is not None and not 0.0 < max_shift_mm < math.inf:
        raise ConfigurationError(
            f"--max-shift-mm {max_shift_mm:g}: give the largest tool shift to accept, above 0 mm."
        )
    found = read_checked_model(file, Acceptance(max_shift_mm, accept_edited), robot_follows=robot_follows)
    remark(map(words.spoken, found.remarks))
    return found


def write_found(model: "Model | None", file: Path, message: Text, words: Catalogue) -> None:
    """Write the model that a campaign gave, or say with the `message` of its answer why there is none."""
    from truepose.exchange.models.file import write_model

    if model is None:
        remark([words.say("terminal.no_model", path=str(file), sentence=message)])
        return
    with writing(file):
        write_model(model, file)


class Form(StrEnum):
    """What a model is written as."""

    URDF = "urdf"
    ROS = "ros"
    DHM = "dhm"
    CONTROLLER = "controller"


def export_command(
    model: ModelFile,
    out: Annotated[Path, typer.Option(help="File to write; tables are CSV if it ends in .csv.")],
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
            help="Fit the table to the full model, so that it contains as much of it as possible.",
        ),
    ] = False,
    max_shift_mm: MaxShiftMm = None,
    accept_edited: AcceptEdited = False,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Export a model for another program, and state what the format cannot hold.

    Example: truepose export robot.json --as urdf --out robot.urdf
    """
    from truepose.exchange.models.exports import export

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
