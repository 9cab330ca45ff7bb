"""The command of the ballbar sphere test. Heavy imports wait until it runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.exchange.files import (
    CampaignPath,
    Json,
    Language,
    LimitMm,
    ReportFile,
    require_folders,
    require_limit,
)
from truepose.cli.output import print_json, print_lines, print_tables, remark
from truepose.domain.errors import ConfigurationError
from truepose.words.catalogue import ENGLISH, catalogue

if TYPE_CHECKING:
    from truepose.domain.results.identification import Model
    from truepose.judgement.sphere.judged import SphereTest


def sphere_command(
    campaign: CampaignPath,
    model: Annotated[
        list[Path] | None, typer.Option(help="Model file; may be given again, its name is the file's.")
    ] = None,
    limit_mm: LimitMm = None,
    report: ReportFile = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Say how true an arm holds a ballbar's length to one ball; status 1 where the ball's place stays open.

    Example: truepose sphere sphere-test --model robot.json --report sphere.html
    """
    from truepose.exchange.campaigns.path import read_campaign_at
    from truepose.judgement.sphere.judged import sphere_test

    require_folders(report)
    require_limit(limit_mm)
    measured, words = read_campaign_at(campaign), catalogue(language)
    remark(map(words.spoken, measured.ignored))
    test = sphere_test(measured, _models(model or []))
    if report is not None:
        from truepose.reports.front.held_to_limit import Limit
        from truepose.reports.spheres.report import write_sphere_report

        robot, simulated = measured.robot.name, bool(measured.simulated)
        write_sphere_report(report, test, robot, words, Limit(limit_mm), simulated=simulated)
    _print(test, measured.robot.name, language, as_json=json)
    return 0 if test.is_complete else 1


def _models(files: list[Path]) -> "dict[str, Model]":
    from truepose.exchange.models.file import read_model
    from truepose.judgement.sphere.judged import NOMINAL

    models = {file.stem: read_model(file) for file in files}
    if len(models) < len(files) or NOMINAL in models:
        raise ConfigurationError(
            f"Model files give the models their names: each needs its own, other than `{NOMINAL}`."
        )
    return models


def _print(test: "SphereTest", robot: str, language: str, *, as_json: bool) -> None:
    if as_json:
        from truepose.exchange.results.spheres import sphere_document

        print_json(sphere_document(test, robot).printed())
        return
    from truepose.reports.spheres.sentences import sphere_table, sphere_test_sentences

    words = catalogue(language)
    print_tables(sphere_table(test, words))
    print_lines(map(words.spoken, sphere_test_sentences(test, words)))
