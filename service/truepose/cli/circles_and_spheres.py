"""The commands of the single-axis circle test and of the ballbar sphere test.

Heavy imports wait until one runs.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from truepose.cli.files import (
    CampaignPath,
    Json,
    Language,
    LimitMm,
    ReportFile,
    UMm,
    require_folders,
    require_limit,
)
from truepose.cli.output import print_json, print_lines, print_tables, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, catalogue, english

if TYPE_CHECKING:
    from collections.abc import Collection

    from truepose.domain.campaign import PointReadings
    from truepose.domain.identification import Model
    from truepose.domain.robot import Robot
    from truepose.validation.circle_test import CircleTest
    from truepose.validation.sphere_test import SphereTest


_NESTS: Final = range(1, 10)  # where no model says which there are


def circles_command(
    points: Annotated[Path, typer.Argument(help="Measured points: one joint turned at a time (CSV).")],
    robot: Annotated[str, typer.Option(help="Shipped robot, robot or cell file, scenario, or model file.")],
    limit_mm: LimitMm = None,
    u_mm: UMm = None,
    report: ReportFile = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Evaluate the errors of each joint turned alone; status 1: a joint's readings form no circle.

    Example: truepose circles circles.csv --robot abb-irb-120 --limit-mm 0.2 --report circles.html
    """
    from truepose.validation.circle_test import circle_test

    require_folders(report)
    require_limit(limit_mm)
    subject, readings = _read(points, robot, u_mm)
    test = circle_test(readings)
    if report is not None:
        from truepose.reports.circles import CircleReport
        from truepose.reports.limits import Limit

        CircleReport(test, subject.name, Limit(limit_mm), language=language).write(report)
    _print_circles(test, subject, language, as_json=json)
    return 1 if test.joints_without else 0


def _read(points: Path, given: str, u_mm: float | None) -> "tuple[Robot, PointReadings]":
    from truepose.domain.campaign import PointReadings
    from truepose.exchange.import_wizard.single_table import read_validation_file

    robot, nests = _robot(given)
    table = read_validation_file(points, robot.n_joints, nests, u_mm=u_mm)
    remark(map(english, table.ignored))
    if not isinstance(table.readings, PointReadings):
        raise ConfigurationError(
            f"{points.name} contains lengths, but a circle test needs positions: x_mm, y_mm, z_mm."
        )
    return robot, table.readings


def _robot(given: str) -> "tuple[Robot, Collection[int]]":
    from truepose.exchange.cells.file import cell_given
    from truepose.exchange.models.file import read_model

    path = Path(given)
    if path.suffix.lower() != ".json":
        return cell_given(given).robot, _NESTS
    model = read_model(path)
    return model.robot, [nest.nest for nest in model.nests]


def _print_circles(test: "CircleTest", robot: "Robot", language: str, *, as_json: bool) -> None:
    if as_json:
        from truepose.exchange.results.circles_and_spheres import circle_document

        print_json(circle_document(test, robot.name).printed())
        return
    from truepose.reports.circles import circle_table, circle_test_sentences
    from truepose.reports.tables import on_terminal

    words = catalogue(language)
    print_tables(on_terminal(circle_table(test, words), narrow=True))
    print_lines(map(words.spoken, circle_test_sentences(test)))


def sphere_command(
    campaign: CampaignPath,
    model: Annotated[
        list[Path] | None, typer.Option(help="Model file, which names the model. May be repeated.")
    ] = None,
    limit_mm: LimitMm = None,
    report: ReportFile = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Evaluate how well an arm holds a ballbar's length to one ball; status 1: the ball cannot be located.

    Example: truepose sphere sphere-test --model robot.json --report sphere.html
    """
    from truepose.exchange.campaigns.zip_file import read_campaign_at
    from truepose.validation.sphere_test import sphere_test

    require_folders(report)
    require_limit(limit_mm)
    measured, words = read_campaign_at(campaign), catalogue(language)
    remark(map(words.spoken, measured.ignored))
    test = sphere_test(measured, _models(model or []))
    if report is not None:
        from truepose.reports.limits import Limit
        from truepose.reports.spheres import SphereReport
        from truepose.reports.traceability import ReportConditions

        stated = ReportConditions(simulated=bool(measured.simulated))
        made = SphereReport(test, measured.robot.name, Limit(limit_mm), conditions=stated, language=language)
        made.write(report)
    _print_spheres(test, measured.robot.name, language, as_json=json)
    return 0 if test.is_complete else 1


def _models(files: list[Path]) -> "dict[str, Model]":
    from truepose.exchange.models.file import read_model
    from truepose.validation.sphere_test import NOMINAL

    models = {file.stem: read_model(file) for file in files}
    if len(models) < len(files) or NOMINAL in models:
        raise ConfigurationError(
            f"Models are named after their files: give each file a different name, other than `{NOMINAL}`."
        )
    return models


def _print_spheres(test: "SphereTest", robot: str, language: str, *, as_json: bool) -> None:
    if as_json:
        from truepose.exchange.results.circles_and_spheres import sphere_document

        print_json(sphere_document(test, robot).printed())
        return
    from truepose.reports.spheres import sphere_table, sphere_test_sentences
    from truepose.reports.tables import on_terminal

    words = catalogue(language)
    print_tables(on_terminal(sphere_table(test, words), narrow=True))
    print_lines(map(words.spoken, sphere_test_sentences(test, words)))
