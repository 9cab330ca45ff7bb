"""The command that identifies what is left in a folder. Heavy imports wait until it runs."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.output import print_lines
from truepose.domain.errors import ConfigurationError, TrueposeError

if TYPE_CHECKING:
    from truepose.exchange.point_lists.inbox import Arrival

_LOOK_S = 2.0  # between two looks: what is the same at both is whole


def watch_command(
    folder: Annotated[Path, typer.Argument(help="Where campaigns, or points and joints, are left.")],
    out: Annotated[Path, typer.Option(help="Folder for what comes of each: answer, model, report.")],
    once: Annotated[bool, typer.Option("--once", help="Take what is there, and end.")] = False,
) -> int:
    """Identify every campaign that comes into a folder, until interrupted. Status 1: one of them failed.

    Example: truepose watch inbox --out results
    """
    if not folder.is_dir():
        raise ConfigurationError(f"{folder} is no folder; make it first.")
    out.mkdir(parents=True, exist_ok=True)
    good = [_taken(arrival, out) for arrival in _whole(folder, once=once)]
    return 0 if all(good) else 1


def _whole(folder: Path, *, once: bool) -> Iterator["Arrival"]:
    """Yield each arrival once, when two looks found it alike; with `once` those of the first."""
    from truepose.exchange.point_lists.inbox import arrivals

    if once:
        yield from arrivals(folder)
        return
    before: set[Arrival] = set()
    taken: set[Arrival] = set()
    while True:
        here = set(arrivals(folder))
        for arrival in sorted((here & before) - taken, key=lambda one: one.name):
            taken.add(arrival)
            yield arrival
        before = here
        time.sleep(_LOOK_S)


def _taken(arrival: "Arrival", out: Path) -> bool:
    """Identify, and say in one line what came of it; returns whether it went well."""
    from truepose.exchange.campaigns.folder import write_campaign
    from truepose.exchange.json_text import render_json
    from truepose.exchange.models.file import write_model
    from truepose.exchange.results.identification import identification_document
    from truepose.identification import identify
    from truepose.reports import ReportInput, write_identification_report
    from truepose.words.catalogue import english

    place = out / arrival.name
    try:
        campaign = arrival.read()
        answer = identify(campaign)
    except TrueposeError as error:
        print_lines([f"{arrival.name}: {error}"])
        return False
    place.mkdir(exist_ok=True)
    write_campaign(campaign, place / "campaign")
    document = identification_document(answer, campaign.robot.name)
    (place / "identification.json").write_text(render_json(document) + "\n", encoding="utf-8")
    write_identification_report(
        place / "report.html", ReportInput(identification=answer, campaign=campaign, language="en")
    )
    if answer.model is not None:
        write_model(answer.model, place / "model.json")
    print_lines([f"{arrival.name}: {english(answer.message)} {place / 'report.html'}"])
    return answer.model is not None
