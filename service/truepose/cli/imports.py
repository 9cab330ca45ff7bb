"""Commands on other programs' files: a campaign of points or of a table, and what a result file says."""

import dataclasses
from collections.abc import Sequence
from datetime import date, datetime
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from truepose.cli.files import Json
from truepose.cli.output import print_json, print_lines, remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import english

if TYPE_CHECKING:
    from truepose.exchange.ballbar_result import BallbarResult
    from truepose.exchange.campaigns.points_with_joints import JoinedTable
    from truepose.exchange.import_wizard.dialogue import Choices, Understood
    from truepose.exchange.json_text import Json as JsonValue


_NAMED = 5  # of those that are left over


class LengthUnit(StrEnum):
    """What the coordinates of a list are in."""

    MM = "mm"
    CM = "cm"
    M = "m"
    IN = "in"


def import_command(
    points: Annotated[
        Path,
        typer.Argument(
            help="Points exported by tracker software; without JOINTS: a table, zip or folder of any program."
        ),
    ],
    joints: Annotated[
        Path | None,
        typer.Argument(help="Joint angles (CSV): config, q1_deg..; optional: nest, dir1.., time_s, point."),
    ] = None,
    *,
    out: Annotated[Path, typer.Option(help="Campaign folder to write.")],
    robot: Annotated[
        str | None,
        typer.Option(
            help="Shipped robot, or your own file (.toml, .urdf); found automatically for some tables."
        ),
    ] = None,
    unit: Annotated[
        LengthUnit | None, typer.Option(help="Unit of the points, if the list does not state it.")
    ] = None,
    u_mm: Annotated[
        float | None, typer.Option("--u-mm", min=1e-6, help="Standard uncertainty of a coordinate [mm].")
    ] = None,
    names: Annotated[
        str, typer.Option(help="Pattern of point names, such as C{config}_N{nest}.")
    ] = "*{config}",
    nest: Annotated[
        list[str] | None,
        typer.Option(help="Centre of a tool nest in the flange frame: x,y,z in mm. May be repeated."),
    ] = None,
    nest_u_mm: Annotated[
        float | None, typer.Option("--nest-u-mm", min=0.0, help="Standard uncertainty of these centres [mm].")
    ] = None,
    measured_on: Annotated[
        datetime | None,
        typer.Option(
            "--measured-on", formats=["%Y-%m-%d"], metavar="YYYY-MM-DD", help="Day of the readings."
        ),
    ] = None,
    robot_serial_number: Annotated[
        str, typer.Option("--robot-serial", help="Serial number of the robot, to follow it over time.")
    ] = "",
    instrument_serial_number: Annotated[
        str, typer.Option("--instrument-serial", help="Serial number of the instrument.")
    ] = "",
    accept_changes: Annotated[
        bool,
        typer.Option("--accept-changes", help="Tables: apply the suggested changes of convention."),
    ] = False,
    json: Json = False,
) -> int:
    """Make a campaign folder from points and their joint angles, or from a table that has both.

    Example: truepose import points.txt joints.csv --robot abb-irb-120 --unit mm --u-mm 0.03 --out mine

    Columns, units and robot of a table are detected and reported: truepose import readings.csv --out mine
    """
    from truepose.exchange.campaigns.folder import write_campaign
    from truepose.exchange.campaigns.points_with_joints import Stated, import_points
    from truepose.exchange.import_wizard.dialogue import Choices

    if out.exists() and any(out.iterdir()):
        raise ConfigurationError(f"{out} is not empty: name another folder.")
    day = None if measured_on is None else measured_on.date()
    serials: dict[str, Any] = {
        "robot_serial_number": robot_serial_number,
        "instrument_serial_number": instrument_serial_number,
    }
    if joints is None:
        choices = Choices(robot=robot, u_mm=u_mm, measured_on=day, undated=True, **serials)
        return _import_table(points, out, choices, accept_changes=accept_changes, json=json)
    if robot is None:
        raise ConfigurationError("A list of points does not name its robot; give it with --robot.")
    centres = [_centre(text) for text in nest or ()]
    stated = Stated(robot, unit and unit.value, u_mm, names, centres, nest_u_mm)
    campaign, found = import_points(points, joints, stated)
    write_campaign(dataclasses.replace(campaign, measured_on=day, **serials), out)
    _remark_undated(day)
    if json:
        left = {"points": list(found.points_alone), "lines": list(found.rows_alone)}
        print_json({"campaign": str(out), "readings": len(found), "left_over": left})
    else:
        print_lines([f"{out}: {len(found)} points with their joint angles.", *_left_over(found, joints.name)])
    return 0


def _import_table(path: Path, out: Path, choices: "Choices", *, accept_changes: bool, json: bool) -> int:
    from truepose.exchange.campaigns.folder import write_campaign
    from truepose.exchange.import_wizard.reading import detection_remarks, read_tables

    found = read_tables(path, choices, accept_changes=accept_changes)
    remark(map(english, detection_remarks(found.understood)))
    if found.campaign is None:
        raise ConfigurationError(_what_is_missing(found.understood))
    write_campaign(found.campaign, out)
    _remark_undated(found.campaign.measured_on)
    if json:
        print_json({
            "campaign": str(out),
            "readings": found.understood.readings,
            "robot": found.campaign.robot.name,
        })
    else:
        print_lines([f"{out}: {found.understood.readings} readings of {found.campaign.robot.name}."])
    return 0


def _remark_undated(day: date | None) -> None:
    if day is None:
        remark([
            "The date of the readings is missing; give it with --measured-on to follow the robot over time."
        ])


def _what_is_missing(understood: "Understood") -> str:
    fault = understood.fault
    if fault is not None:
        return f"{fault.file}{f', line {fault.line}' if fault.line else ''}: {fault.sentence}."
    return " ".join(english(question.sentence) for question in understood.questions)


def _centre(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ConfigurationError(f"--nest {text}: give three numbers in mm, e.g. 75,93.675,215.") from error
    return x, y, z


def _left_over(found: "JoinedTable", joints: str) -> list[str]:
    """Return what belongs to nothing, so that nobody believes it was used."""
    said = []
    if found.points_alone:
        said.append(f"Points without joint angles (ignored): {_some(found.points_alone)}.")
    if found.rows_alone:
        said.append(
            f"Lines of {joints} without a point (ignored): {_some(list(map(str, found.rows_alone)))}."
        )
    return said


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(names[:_NAMED])
    return shown if len(names) <= _NAMED else f"{shown} and {len(names) - _NAMED} more"


_HEAD = (
    "test",
    "machine",
    "plane",
    "started",
    "operator",
    "part_number",
    "ballbar_serial",
    "last_calibrated",
)
_NO_READINGS = (
    "The raw readings are in an undocumented format and were not read; this file has no lengths for a "
    "calibration."
)


def inspect_command(
    result: Annotated[Path, typer.Argument(help="Result file of a Renishaw QC20-W (.b5r).")],
    json: Json = False,
) -> int:
    """Show the contents of a Renishaw QC20-W result file: test, machine, ballbar, features.

    Example: truepose inspect "XY 360deg 150mm 20260105-101500_42.b5r" --json
    """
    from truepose.exchange.ballbar_result import read_ballbar_result

    read = read_ballbar_result(result)
    if json:
        print_json(_document(read))
    else:
        print_lines(_lines(read))
    return 0


def _document(result: "BallbarResult") -> "JsonValue":
    head: dict[str, JsonValue] = {key: getattr(result, key) for key in _HEAD}
    return head | {
        "features": [
            {"name": feature.name, "kind": feature.kind, "text": feature.text, "value": feature.value}
            for feature in result.features
        ],
        "readings": None,
        "not_understood": dict(result.not_understood),
        "remark": _NO_READINGS,
    }


def _lines(result: "BallbarResult") -> list[str]:
    head = [f"{key.replace('_', ' ')}: {getattr(result, key) or 'not stated'}" for key in _HEAD]
    features = [f"  {feature.name} ({feature.kind}): {feature.text}" for feature in result.features]
    passed_over = ", ".join(f"{name} ({count})" for name, count in result.not_understood.items())
    return [
        *head,
        f"features: {len(features)}, as the maker's software computed them",
        *features,
        f"elements not understood: {passed_over or 'none'}",
        _NO_READINGS,
    ]
