"""The command that makes a campaign of points from other software. Heavy imports wait until it runs."""

import dataclasses
from collections.abc import Sequence
from datetime import date, datetime
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from truepose.cli.exchange.files import Json
from truepose.cli.output import print_json, print_lines, remark
from truepose.domain.errors import ConfigurationError
from truepose.words.catalogue import english

if TYPE_CHECKING:
    from truepose.exchange.brought.choices import Choices
    from truepose.exchange.brought.understood import Understood
    from truepose.exchange.point_lists.joined import Joined

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
            help="Points as a tracker's software exports them; alone: a table, zip or folder of any program."
        ),
    ],
    joints: Annotated[
        Path | None,
        typer.Argument(help="Joint angles (CSV): config, q1_deg.., perhaps nest, dir1.., time_s, point."),
    ] = None,
    *,
    out: Annotated[Path, typer.Option(help="Campaign folder to write.")],
    robot: Annotated[
        str | None,
        typer.Option(help="Shipped robot, or a file of one's own (.toml, .urdf); a table may find its own."),
    ] = None,
    unit: Annotated[
        LengthUnit | None, typer.Option(help="Of the points, where the list does not say it.")
    ] = None,
    u_mm: Annotated[
        float | None, typer.Option("--u-mm", min=1e-6, help="Standard uncertainty of a coordinate [mm].")
    ] = None,
    names: Annotated[
        str, typer.Option(help="How names of points say configuration and nest, e.g. C{config}_N{nest}.")
    ] = "*{config}",
    nest: Annotated[
        list[str] | None,
        typer.Option(help="Centre of a tool nest in the last frame: x,y,z in mm. May be repeated."),
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
        str, typer.Option("--robot-serial", help="Serial number of the robot: whose life it stands in.")
    ] = "",
    instrument_serial_number: Annotated[
        str, typer.Option("--instrument-serial", help="Serial number of what measured.")
    ] = "",
    accept_changes: Annotated[
        bool,
        typer.Option("--accept-changes", help="Of a table: make the changes of convention that are offered."),
    ] = False,
    json: Json = False,
) -> int:
    """Make a campaign folder of a list of points and their joint angles, or of a table that has both.

    Example: truepose import points.txt joints.csv --robot abb-irb-120 --unit mm --u-mm 0.03 --out mine

    Of a table columns, units and robot are guessed and told: truepose import readings.csv --out mine
    """
    from truepose.exchange.brought.choices import Choices
    from truepose.exchange.campaigns.folder import write_campaign
    from truepose.exchange.point_lists.importing import Stated, import_points

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
        raise ConfigurationError("A list of points does not say its robot: name it with --robot.")
    centres = [_centre(text) for text in nest or ()]
    stated = Stated(robot, unit and unit.value, u_mm, names, centres, nest_u_mm)
    campaign, found = import_points(points, joints, stated)
    write_campaign(dataclasses.replace(campaign, measured_on=day, **serials), out)
    _remark_undated(day)
    if json:
        left = {"points": list(found.points_alone), "lines": list(found.rows_alone)}
        print_json({"campaign": str(out), "readings": len(found), "left_over": left})
    else:
        print_lines([f"{out}: {len(found)} points at their joint angles.", *_left_over(found, joints.name)])
    return 0


def _import_table(path: Path, out: Path, choices: "Choices", *, accept_changes: bool, json: bool) -> int:
    from truepose.exchange.brought.table_files import read_tables, told
    from truepose.exchange.campaigns.folder import write_campaign

    found = read_tables(path, choices, accept_changes=accept_changes)
    remark(map(english, told(found.understood)))
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
        remark(["Nobody said the day of the readings; --measured-on says it, for a robot seen over months."])


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


def _left_over(found: "Joined", joints: str) -> list[str]:
    """Return what belongs to nothing, so that nobody believes it was used."""
    said = []
    if found.points_alone:
        said.append(f"Points without joint angles, left out: {_some(found.points_alone)}.")
    if found.rows_alone:
        said.append(
            f"Lines of {joints} without a point, left out: {_some(list(map(str, found.rows_alone)))}."
        )
    return said


def _some(names: Sequence[str]) -> str:
    shown = ", ".join(names[:_NAMED])
    return shown if len(names) <= _NAMED else f"{shown} and {len(names) - _NAMED} more"
