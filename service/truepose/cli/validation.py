"""The command that judges a model. Heavy imports wait until it runs."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import (
    AcceptEdited,
    Json,
    Language,
    LimitMm,
    MaxShiftMm,
    ReportFile,
    UMm,
    require_folders,
    require_limit,
)
from truepose.cli.models import checked_model
from truepose.cli.output import print_json, print_tables, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import ENGLISH, Catalogue, catalogue
from truepose.messages.message import message

if TYPE_CHECKING:
    from truepose.domain.campaign import Readings
    from truepose.domain.identification import Model
    from truepose.domain.validation import DecisionRule, Validation
    from truepose.exchange.json_text import Json as JsonValue
    from truepose.validation.iso9283.pose_test import PoseTest


class Rule(StrEnum):
    """How a limit counts the uncertainty of the readings."""

    GUARD_BAND = "guard-band"
    SIMPLE = "simple"


def validate_command(
    model: Annotated[Path, typer.Argument(help="Model file.")],
    points: Annotated[Path, typer.Argument(help="Measured rows that the model was not identified from.")],
    limit_mm: LimitMm = None,
    u_mm: UMm = None,
    decision_rule: Annotated[
        Rule, typer.Option(help="Whether to include the uncertainty of the readings (ISO 14253-1).")
    ] = Rule.GUARD_BAND,
    iso9283: Annotated[
        bool, typer.Option("--iso9283", help="Rows are cycles of poses: add the figures of ISO 9283.")
    ] = False,
    report: ReportFile = None,
    load: Annotated[str, typer.Option(help="Load during the test, for the report.")] = "",
    speed_mm_s: Annotated[float | None, typer.Option(help="Speed of the tool, for the report.")] = None,
    speed_percent: Annotated[
        float | None, typer.Option(help="Speed relative to rated speed, for the report.")
    ] = None,
    settle_s: Annotated[
        float | None, typer.Option(help="Delay between motion and measurement, for the report.")
    ] = None,
    warm_up: Annotated[str, typer.Option(help="Warm-up of the robot, for the report.")] = "",
    instrument: Annotated[str, typer.Option(help="Measuring instrument, for the report.")] = "",
    max_shift_mm: MaxShiftMm = None,
    accept_edited: AcceptEdited = False,
    # Hidden, since they are always refused: whoever knows them from `identify` is told why.
    set_aside: Annotated[
        list[str] | None, typer.Option("--set-aside", "--set-aside-file", hidden=True)
    ] = None,
    language: Language = ENGLISH,
    json: Json = False,
) -> int:
    """Validate a model on readings that it was not identified from; status 1: it fails.

    Example: truepose validate robot.json cycles.csv --iso9283 --limit-mm 0.2 --report accuracy.html
    """
    from truepose.reports.traceability import Instrument, ReportConditions
    from truepose.reports.validation import ValidationReport
    from truepose.validation.cautions import validation_cautions
    from truepose.validation.validate import validate

    require_limit(limit_mm)
    require_folders(report)
    if set_aside:
        raise ConfigurationError(message("refused.set_aside_validation"))
    words = catalogue(language)
    checked = checked_model(model, max_shift_mm, words, accept_edited=accept_edited, robot_follows=False)
    identified, readings = checked.model, _readings(checked.model, points, u_mm, words)
    rule: DecisionRule = "simple" if decision_rule is Rule.SIMPLE else "guard band"
    answer = validate(identified, readings, limit_mm=limit_mm, rule=rule)
    test = _pose_test(identified, readings) if iso9283 else None
    cautions = tuple(validation_cautions(identified, readings))
    remark(map(words.spoken, cautions))
    if report is not None:
        devices = (Instrument("instrument", model=instrument),) if instrument else ()
        conditions = ReportConditions(
            load=load,
            warm_up=warm_up,
            tool_speed_mm_s=speed_mm_s,
            speed_percent=speed_percent,
            settle_s=settle_s,
            instruments=devices,
        )
        judged = ValidationReport(
            answer, identified, readings, cautions, test, conditions=conditions, language=language
        )
        judged.write(report)
    if json:
        print_json(_document(answer, test) | {"model_file": checked.document})
    else:
        _show(answer, test, words)
    return 0 if answer.passed else 1


def _readings(identified: "Model", points: Path, u_mm: float | None, words: Catalogue) -> "Readings":
    from truepose.exchange.import_wizard.single_table import read_validation_file

    measured = read_validation_file(
        points,
        identified.robot.n_joints,
        [nest.nest for nest in identified.nests],
        identified.targets,
        u_mm,
    )
    remark(map(words.spoken, measured.ignored))
    return measured.readings


def _pose_test(model: "Model", readings: "Readings") -> "PoseTest":
    from truepose.validation.iso9283.pose_test import pose_test

    return pose_test(model, readings)


def _show(answer: "Validation", test: "PoseTest | None", words: Catalogue) -> None:
    from truepose.reports.pose_test import pose_test_summary
    from truepose.reports.validation import validation_summary

    print_tables(validation_summary(answer, words))
    if test is not None:
        print_tables(pose_test_summary(test, words))


def _document(answer: "Validation", test: "PoseTest | None") -> "dict[str, JsonValue]":
    from truepose.exchange.results.validation import pose_test_document, validation_document

    document = validation_document(answer)
    return document if test is None else document | {"iso9283": pose_test_document(test)}
