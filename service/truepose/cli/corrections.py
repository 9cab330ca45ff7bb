"""The command that corrects targets. Heavy imports wait until it runs."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TextIO

import typer

from truepose.cli.files import Json, Language, require_folders, writing
from truepose.cli.output import print_json, print_lines, remark, shown_progress
from truepose.domain.errors import ConfigurationError
from truepose.words.catalogue import ENGLISH, Catalogue, catalogue

if TYPE_CHECKING:
    from truepose.correction import Summary
    from truepose.domain.results import Model
    from truepose.exchange.programs.corrected import Understood
    from truepose.exchange.programs.program import LeftAlone, Pose

_TABLE: Final = ".csv"
_UNIT: Final = 1e-6  # of the length of a quaternion


class Frame(StrEnum):
    """What targets are given in."""

    WORLD = "world"
    BASE = "base"


def correct_command(
    model: Annotated[Path, typer.Argument(help="Model file written by `identify --model-out`.")],
    targets: Annotated[
        Path, typer.Argument(help="A table (.csv) of target, x_mm.. qw.., or a robot program by its ending.")
    ],
    out: Annotated[Path, typer.Option(help="Where the corrected targets go, or the program again.")],
    frame: Annotated[
        Frame | None,
        typer.Option(
            help="What targets are given in: the frame of the readings (as tables are), or the robot's base "
            "(as programs are)."
        ),
    ] = None,
    define: Annotated[
        list[str] | None,
        typer.Option(help="Of a program: a tool or work object that it only names, NAME=x,y,z,qw,qx,qy,qz."),
    ] = None,
    beside: Annotated[
        list[Path] | None, typer.Option(help="Of a program: another file of it; it is read, not written.")
    ] = None,
    branch: Annotated[
        str | None,
        typer.Option(help="Of a program: branch of poses that do not say theirs, e.g. front/up/no flip."),
    ] = None,
    angles: Annotated[
        str | None, typer.Option(help="Of G-code: axes of A, B, C: xyz, zyx or fixed xyz.")
    ] = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Find joint targets that make the real tool arrive; status 1 when some target was not corrected.

    Of robot programs only the numbers of targets change: ABB RAPID (.mod .sys .prg), KUKA KRL (.src .dat),
    FANUC LS (.ls), URScript (.script), Yaskawa INFORM (.jbi), Staubli VAL3 (.dtx), G-code (.nc .gcode .cnc
    .tap), JSON (.json). What moves the robot and cannot be corrected so is listed.

    Example: truepose correct robot.json weld.mod --out weld-corrected.mod
    """
    from truepose.exchange.models.file import read_model

    require_folders(out)
    words, identified = catalogue(language), read_model(model)
    if targets.suffix.lower() == _TABLE:
        summary = _corrected(identified, targets, out, frame or Frame.WORLD, words)
        left: tuple[LeftAlone, ...] = ()
    else:
        understood = _understood(frame, define or [], branch)
        summary, left = _correct_program(identified, targets, out, understood, beside or [], angles)
    if json:
        from truepose.exchange.results.corrections import correction_document

        print_json(correction_document(summary, left))
    else:
        from truepose.reports.corrections import correction_sentences, left_alone_sentences

        print_lines(map(words.spoken, (*correction_sentences(summary), *left_alone_sentences(left))))
    return 0 if summary.solved == summary.targets and not left else 1


def _understood(frame: Frame | None, define: Sequence[str], branch: str | None) -> "Understood":
    from truepose.exchange.programs.branches import branch_of_words
    from truepose.exchange.programs.corrected import Meant, Understood

    number = None if branch is None else branch_of_words(branch)
    if branch is not None and number is None:
        raise ConfigurationError(f"--branch {branch}: name one such as front/up/no flip or back/down/flip.")
    meant = Meant.WORLD if frame is Frame.WORLD else Meant.BASE
    return Understood(meant, dict(map(_defined, define)), number)


def _defined(text: str) -> "tuple[str, Pose]":
    """Return the name and the pose that `NAME=x,y,z,qw,qx,qy,qz` says."""
    from truepose.exchange.programs.program import Pose

    name, _, numbers = text.partition("=")
    try:
        x, y, z, qw, qx, qy, qz = (float(number) for number in numbers.split(","))
    except ValueError:
        raise ConfigurationError(f"--define {text}: give NAME=x,y,z,qw,qx,qy,qz, in mm.") from None
    if abs(math.hypot(qw, qx, qy, qz) - 1.0) > _UNIT:
        raise ConfigurationError(f"--define {text}: its last four numbers are no quaternion of length 1.")
    return name.strip(), Pose((x, y, z), (qw, qx, qy, qz))


def _correct_program(
    model: "Model",
    file: Path,
    out: Path,
    understood: "Understood",
    beside: Sequence[Path],
    angles: str | None,
) -> "tuple[Summary, tuple[LeftAlone, ...]]":
    from truepose.correction import Summary
    from truepose.exchange.input_file import read_bytes
    from truepose.exchange.programs.corrected import corrected_program
    from truepose.exchange.programs.formats import read_program

    others = {other.name: read_bytes(other) for other in beside}
    program = read_program(read_bytes(file), file.name, beside=others, angles=angles)
    answer = corrected_program(model, program, understood)
    with writing(out):
        out.write_bytes(answer.data)
    summary = Summary()
    summary.add(answer.names, answer.found)
    return summary, answer.left_alone


def _corrected(model: "Model", targets: Path, out: Path, frame: Frame, words: Catalogue) -> "Summary":
    from truepose.correction import Summary, correct, in_world
    from truepose.exchange.tables.targets import CorrectionWriter, read_targets
    from truepose.judgement.cautions import prediction_cautions

    summary = Summary()
    with _replacing(out) as stream, shown_progress() as progress:
        writer = CorrectionWriter(stream)
        for part in read_targets(targets, model.robot.n_joints, [nest.nest for nest in model.nests]):
            goals = part.goals if frame is Frame.WORLD else in_world(model, part.goals)
            found = correct(model, goals, part.branch)
            if not summary.targets:
                cautions = prediction_cautions(model, goals.at(found.joints_rad))
                remark(map(words.spoken, (*part.ignored, *cautions)))
            writer.write(part.names, found)
            summary.add(part.names, found)
            progress(part.share, f"{summary.targets:,} targets")
    return summary


@contextmanager
def _replacing(file: Path) -> Iterator[TextIO]:
    """Write beside a file and put it in its place at the end: half a table is never left there."""
    beside = file.with_name(f"{file.name}.part")
    try:
        with writing(file):
            with beside.open("w", encoding="utf-8", newline="\n") as stream:
                yield stream
            beside.replace(file)
    finally:
        beside.unlink(missing_ok=True)
