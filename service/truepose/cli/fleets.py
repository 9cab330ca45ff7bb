"""The command that compares robots of one type. Heavy imports wait until it runs."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.batch_analysis import campaigns_of
from truepose.cli.files import (
    Json,
    Language,
    ReportFile,
    Workers,
    read_measured,
    require_folders,
    writing,
)
from truepose.cli.output import print_json, print_lines, print_tables, progress_bar, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, Catalogue, catalogue

if TYPE_CHECKING:
    from truepose.analysis.archive import ArchivedCampaign
    from truepose.analysis.fleets.comparison import FleetFound
    from truepose.domain.campaign import Campaign
    from truepose.fleet.interim_check import CauseGrowth
    from truepose.fleet.predicted_accuracy import PredictedAccuracy

    OfCheck = tuple[str, tuple[CauseGrowth, ...]]


def fleet_command(
    archive: Annotated[
        str,
        typer.Argument(
            help="Folder of campaign folders or zips, or a database of a service or a plant (file or URL)."
        ),
    ],
    table: Annotated[
        Path | None,
        typer.Option(help="Table of what was measured when (CSV): campaign, robot, instrument, day."),
    ] = None,
    of_type: Annotated[
        str | None, typer.Option("--type", help="Robot type, if the archive has several.")
    ] = None,
    limit: Annotated[float, typer.Option(help="Largest acceptable change [mm].")] = 0.1,
    out: Annotated[Path | None, typer.Option(help="Folder that caches the result of each campaign.")] = None,
    check: Annotated[
        Path | None, typer.Option(help="Write the interim check of the robot that is due next here (CSV).")
    ] = None,
    checked: Annotated[
        Path | None,
        typer.Option(help="Campaign of an interim check (not in the archive): report what has changed."),
    ] = None,
    growth: Annotated[
        float, typer.Option(help="Smallest change [mm] that the interim check must detect.")
    ] = 0.05,
    pooled: Annotated[
        Path | None,
        typer.Option(help="Write the prior for another robot of this type here, for `identify --fleet`."),
    ] = None,
    new: Annotated[
        Path | None,
        typer.Option(help="Write the configurations to measure on another robot of this type here (CSV)."),
    ] = None,
    report: ReportFile = None,
    workers: Workers = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Compare robots of one type over months: what changes, since when, and which to measure next.

    It may be interrupted and started again with the same --out. Status 1: a campaign is not compared.

    Example: truepose fleet campaigns --out told --report fleet.html
    """
    require_folders(check, pooled, new, report)
    _require_above_zero("--limit", limit)
    _require_above_zero("--growth", growth)
    words = catalogue(language)
    with campaigns_of(archive) as campaigns:
        found = _compared(campaigns, table, out, of_type, workers)
        if check is not None:
            remark(_write_check(check, found, campaigns, (limit, growth), words))
        promised = None if pooled is None and new is None else _promised(found, campaigns, limit)
    if pooled is not None:
        _write_pooled(pooled, found)
    if promised is not None:
        remark([_promise_said(promised, words)])
        _write_new(new, promised)
    if report is not None:
        _write_report(report, found, limit, words)
    of_check = None if checked is None else _judged(checked, found, growth)
    if json:
        _print_document(found, limit, promised, of_check)
    else:
        _print(found, limit, of_check, words)
    return 1 if found.left_out else 0


def _require_above_zero(option: str, size_mm: float) -> None:
    if not 0.0 < size_mm < float("inf"):
        raise ConfigurationError(f"{option} {size_mm:g}: give a size above 0 mm.")


def _compared(
    campaigns: "Sequence[ArchivedCampaign]",
    table: Path | None,
    out: Path | None,
    of_type: str | None,
    where: str | None,
) -> "FleetFound":
    from truepose.analysis.fleets.comparison import FleetArchive
    from truepose.analysis.parallel.local_pool import workers
    from truepose.exchange.tables.files import read_visits

    work = FleetArchive(campaigns, None if table is None else read_visits(table), out)
    with workers(where, len(campaigns)) as cluster, progress_bar() as told:
        work.tell(cluster, told)
    return work.compare(of_type)


def _write_check(
    file: Path,
    found: "FleetFound",
    campaigns: "Sequence[ArchivedCampaign]",
    limit_and_growth_mm: tuple[float, float],
    words: Catalogue,
) -> list[str]:
    from truepose.analysis.fleets.checks import check_from
    from truepose.exchange.tables.targets import write_configurations
    from truepose.fleet.interim_check import checked_causes, needs_both_directions
    from truepose.fleet.trend import due

    limit_mm, grown_mm = limit_and_growth_mm
    robot = due(found.account, limit_mm)[0].robot
    chosen = check_from(found.account, robot, _last_of(robot, found, campaigns), grown_mm)
    with writing(file):
        write_configurations(file, chosen.joints_rad, chosen.nest)
    counts = {"number": len(chosen.nest), "causes": len(checked_causes(found.account))}
    key = "fleet.check" if chosen.enough else "fleet.check.not_enough"
    told = [words.say(key, robot=robot, grown_mm=grown_mm, **counts)]
    gaps = any(needs_both_directions(one.change.cause) for one in found.account.named)
    return [*told, *([words.say("fleet.check.gaps")] if gaps else [])]


def _last_of(robot: str, found: "FleetFound", campaigns: "Sequence[ArchivedCampaign]") -> "Campaign":
    from truepose.analysis.job_queue.tasks import stored_campaign

    name = found.last_campaign_of(robot)
    return stored_campaign(next(one for one in campaigns if one.name == name).load())


def _promised(
    found: "FleetFound", campaigns: "Sequence[ArchivedCampaign]", limit_mm: float
) -> "PredictedAccuracy":
    """Say what a further robot needs, measured as the one is that was least called for."""
    from truepose.analysis.fleets.checks import promise_from
    from truepose.fleet.trend import due

    robot = due(found.account, limit_mm)[-1].robot
    return promise_from(found.account, robot, _last_of(robot, found, campaigns))


def _promise_said(promised: "PredictedAccuracy", words: Catalogue) -> str:
    from truepose.fleet.sentences import new_robot_said

    return words.spoken(new_robot_said(promised))


def _write_new(file: Path | None, promised: "PredictedAccuracy") -> None:
    from truepose.exchange.tables.targets import write_configurations

    if file is not None:
        with writing(file):
            write_configurations(file, promised.pooled.joints_rad, promised.pooled.nest)


def _write_pooled(file: Path, found: "FleetFound") -> None:
    from truepose.exchange.models.file import Pooled, write_pooled
    from truepose.fleet.predicted_accuracy import of_a_new_robot

    with writing(file):
        write_pooled(file, Pooled(found.robot.name, of_a_new_robot(found.account)))


def _write_report(file: Path, found: "FleetFound", limit_mm: float, words: Catalogue) -> None:
    from truepose.reports.fleet import FleetReport
    from truepose.reports.traceability import ReportConditions

    left_out = tuple((one.campaign, one.why) for one in found.left_out)
    stated = ReportConditions(simulated=found.simulated)
    made = FleetReport(
        found.account, found.robot.name, limit_mm, left_out, conditions=stated, language=words.language
    )
    made.write(file)


def _judged(campaign: Path, found: "FleetFound", growth_mm: float) -> "OfCheck":
    from truepose.analysis.fleets.checks import grown_in

    measured = read_measured(campaign)
    if measured.robot.name != found.robot.name:
        raise ConfigurationError(
            f"{campaign.name} is of a {measured.robot.name}, but the fleet is of {found.robot.name}."
        )
    return grown_in(found.account, measured, growth_mm)


def _print_document(
    found: "FleetFound", limit_mm: float, promised: "PredictedAccuracy | None", of_check: "OfCheck | None"
) -> None:
    from truepose.exchange.results.fleet import CheckedDocument, fleet_document

    document = fleet_document(
        found.account,
        found.robot,
        limit_mm,
        found.left_out,
        simulated=found.simulated,
        new_robot=promised,
        checked=None if of_check is None else CheckedDocument.of_robot(*of_check),
    )
    print_json(document.printed())


def _print(found: "FleetFound", limit_mm: float, of_check: "OfCheck | None", words: Catalogue) -> None:
    from truepose.fleet.sentences import grown_said
    from truepose.reports.fleet import fleet_summary

    print_tables(fleet_summary(found.account, limit_mm, words))
    print_lines(words.say("fleet.left_out", campaign=one.campaign, why=one.why) for one in found.left_out)
    if of_check is not None:
        print_lines(map(words.spoken, grown_said(*of_check)))
