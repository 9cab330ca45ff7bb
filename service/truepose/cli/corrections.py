"""The command that corrects targets. Heavy imports wait until it runs."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, BinaryIO

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
from truepose.cli.models import checked_model
from truepose.cli.output import print_json, print_lines, progress_bar, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, catalogue

if TYPE_CHECKING:
    from truepose.domain.identification import Model
    from truepose.exchange.corrections import Answer
    from truepose.exchange.programs.correction_request import CorrectionRequest


class Frame(StrEnum):
    """What targets are given in."""

    WORLD = "world"
    BASE = "base"


def correct_command(
    model: ModelFile,
    targets: Annotated[
        Path,
        typer.Argument(
            help="Table of targets (.csv: target, x_mm.. qw..) or robot program (type by file extension)."
        ),
    ],
    out: Annotated[Path, typer.Option(help="File for the corrected targets or program.")],
    frame: Annotated[
        Frame | None,
        typer.Option(
            help="Frame of the targets: that of the readings (default for tables), or the robot's base "
            "(default for programs)."
        ),
    ] = None,
    define: Annotated[
        list[str] | None,
        typer.Option(
            help="Programs: tool or work object that the program names but does not define, as "
            "NAME=x,y,z,qw,qx,qy,qz."
        ),
    ] = None,
    beside: Annotated[
        list[Path] | None,
        typer.Option(help="Programs: another file of the program, which is read but not written."),
    ] = None,
    branch: Annotated[
        str | None,
        typer.Option(help="Programs: branch of poses that do not state one, such as front/up/no flip."),
    ] = None,
    coupled: Annotated[
        bool,
        typer.Option(help="FANUC: joint 3 is measured from the horizontal; joint targets are corrected."),
    ] = False,
    angles: Annotated[
        str | None, typer.Option(help="G-code: rotation order of A, B, C: xyz, zyx or fixed xyz.")
    ] = None,
    as_written: Annotated[
        bool,
        typer.Option(help="Correct targets even if another unit or frame would fit them better."),
    ] = False,
    max_shift_mm: MaxShiftMm = None,
    accept_edited: AcceptEdited = False,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Correct targets so that the real tool reaches them; status 1: a target was not corrected.

    Of robot programs only the numbers of targets change: ABB RAPID (.mod .sys .prg), KUKA KRL (.src .dat),
    FANUC LS (.ls), URScript (.script), Yaskawa INFORM (.jbi), Staubli VAL3 (.dtx), G-code (.nc .gcode .cnc
    .tap), JSON (.json). What moves the robot and cannot be corrected so is listed.

    Example: truepose correct robot.json weld.mod --out weld-corrected.mod
    """
    require_folders(out)
    _require_another_file(targets, out)
    words = catalogue(language)
    checked = checked_model(model, max_shift_mm, words, accept_edited=accept_edited)
    asked = replace(
        _asked(frame, define or [], branch, angles, beside or []), coupled=coupled, as_written=as_written
    )
    answer = _corrected(checked.model, targets, out, asked)
    withheld = () if answer.withheld is None else (answer.withheld,)
    remark(map(words.spoken, (*answer.cautions, *withheld)))
    totals, left = answer.summary.totals, answer.left_alone
    if json:
        from truepose.exchange.results.corrections import correction_document

        print_json(correction_document(totals, left) | {"model_file": checked.document})
    else:
        from truepose.reports.correction import correction_sentences, left_alone_sentences

        print_lines(map(words.spoken, (*correction_sentences(totals), *left_alone_sentences(left))))
    return 0 if totals.solved == totals.targets and not left and not withheld else 1


def _asked(
    frame: Frame | None, define: Sequence[str], branch: str | None, angles: str | None, beside: Sequence[Path]
) -> "CorrectionRequest":
    from truepose.exchange.document import read_bytes
    from truepose.exchange.programs.correction_request import CorrectionRequest, branch_named, frame_defined
    from truepose.exchange.programs.program import TargetConventions

    return CorrectionRequest(
        meant=None if frame is None else TargetConventions(frame.value),
        defined=dict(frame_defined(text, "--define") for text in define),
        branch=None if branch is None else branch_named(branch, "--branch"),
        angles=angles,
        beside={other.name: read_bytes(other) for other in beside},
    )


def _require_another_file(targets: Path, out: Path) -> None:
    """Keep the original: a second run would correct what is corrected already."""
    if out.exists() and targets.exists() and out.samefile(targets):
        raise ConfigurationError(f"--out {out} is the targets file itself; choose another name.")


def _corrected(model: "Model", targets: Path, out: Path, asked: "CorrectionRequest") -> "Answer":
    from truepose.exchange.corrections import Rows, correct_file
    from truepose.exchange.document import read_bytes

    with _replacing(out) as stream, progress_bar() as progress:

        def seen(rows: Rows) -> None:
            progress(rows.share, f"{rows.lines[-1]:,} lines" if len(rows.lines) else "")

        answer = correct_file(model, targets.name, read_bytes(targets), asked, stream.file, seen)
        stream.kept = answer.withheld is None
        return answer


@dataclass(slots=True)
class _OutputFile:
    """A file that is written beside another one; `kept` if it takes its place."""

    file: BinaryIO
    kept: bool = True


@contextmanager
def _replacing(file: Path) -> Iterator[_OutputFile]:
    """Write beside a file and put it in its place at the end: half of one is never left there."""
    beside = file.with_name(f"{file.name}.part")
    try:
        with writing(file):
            with beside.open("wb") as stream:
                written = _OutputFile(stream)
                yield written
            if written.kept:
                beside.replace(file)
    finally:
        beside.unlink(missing_ok=True)
