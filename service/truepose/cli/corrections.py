"""The command that corrects targets. Heavy imports wait until it runs."""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TextIO

import typer

from truepose.cli.files import Json, Language, require_folders, writing
from truepose.cli.output import print_json, print_lines, remark, shown_progress
from truepose.words.catalogue import ENGLISH, Catalogue, catalogue

if TYPE_CHECKING:
    from truepose.correction import Summary
    from truepose.domain.results import Model


class Frame(StrEnum):
    """What targets are given in."""

    WORLD = "world"
    BASE = "base"


def correct_command(
    model: Annotated[Path, typer.Argument(help="Model file written by `identify --model-out`.")],
    targets: Annotated[Path, typer.Argument(help="CSV of target, x_mm.. qw.., and what else is known.")],
    out: Annotated[Path, typer.Option(help="Where the corrected targets go.")],
    frame: Annotated[
        Frame, typer.Option(help="What targets are given in: the frame of the readings, or the robot's base.")
    ] = Frame.WORLD,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Find joint targets that make the real tool arrive; status 1 when some target was not corrected.

    Example: truepose correct robot.json targets.csv --out corrected.csv
    """
    from truepose.exchange.models.file import read_model

    require_folders(out)
    words = catalogue(language)
    summary = _corrected(read_model(model), targets, out, frame, words)
    if json:
        from truepose.exchange.results.corrections import correction_document

        print_json(correction_document(summary))
    else:
        from truepose.reports.corrections import correction_sentences

        print_lines(map(words.spoken, correction_sentences(summary)))
    return 0 if summary.solved == summary.targets else 1


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
                remark([*part.ignored, *map(words.spoken, cautions)])
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
