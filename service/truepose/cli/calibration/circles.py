"""The command of the single-axis circle test. Heavy imports wait until it runs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from truepose.cli.exchange.files import Json, Language, LimitMm, ReportFile, require_folders, require_limit
from truepose.cli.output import print_json, print_lines, print_tables, remark
from truepose.domain.errors import ConfigurationError
from truepose.words.catalogue import ENGLISH, catalogue, english

if TYPE_CHECKING:
    from collections.abc import Collection

    from truepose.domain.measurement.campaign import PointReadings
    from truepose.domain.robot import Robot
    from truepose.judgement.circle.judged import CircleTest

_NESTS: Final = range(1, 10)  # where no model says which there are


def circles_command(
    points: Annotated[Path, typer.Argument(help="Measured points: one joint turned at a time (CSV).")],
    robot: Annotated[str, typer.Option(help="Shipped robot, robot or cell file, scenario, or model file.")],
    limit_mm: LimitMm = None,
    report: ReportFile = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Say what each joint errs by, turned alone; status 1 where a joint's readings give no circle.

    Example: truepose circles circles.csv --robot abb-irb-120 --limit-mm 0.2 --report circles.html
    """
    from truepose.judgement.circle.judged import circle_test

    require_folders(report)
    require_limit(limit_mm)
    subject, readings = _read(points, robot)
    test = circle_test(readings)
    if report is not None:
        from truepose.reports.circles.report import write_circle_report
        from truepose.reports.front.held_to_limit import Limit

        write_circle_report(report, test, subject.name, catalogue(language), Limit(limit_mm))
    _print(test, subject, language, as_json=json)
    return 1 if test.joints_without else 0


def _read(points: Path, given: str) -> "tuple[Robot, PointReadings]":
    from truepose.domain.measurement.campaign import PointReadings
    from truepose.exchange.tables.files import read_validation_file

    robot, nests = _robot(given)
    table = read_validation_file(points, robot.n_joints, nests)
    remark(map(english, table.ignored))
    if not isinstance(table.readings, PointReadings):
        raise ConfigurationError(
            f"{points.name} holds lengths: a circle test takes positions, x_mm y_mm z_mm."
        )
    return robot, table.readings


def _robot(given: str) -> "tuple[Robot, Collection[int]]":
    from truepose.exchange.cells.given import cell_given
    from truepose.exchange.models.file import read_model

    path = Path(given)
    if path.suffix.lower() != ".json":
        return cell_given(given).robot, _NESTS
    model = read_model(path)
    return model.robot, [nest.nest for nest in model.nests]


def _print(test: "CircleTest", robot: "Robot", language: str, *, as_json: bool) -> None:
    if as_json:
        from truepose.exchange.results.circles import circle_document

        print_json(circle_document(test, robot.name).printed())
        return
    from truepose.reports.circles.sentences import circle_table, circle_test_sentences

    words = catalogue(language)
    print_tables(circle_table(test, words))
    print_lines(map(words.spoken, circle_test_sentences(test)))
