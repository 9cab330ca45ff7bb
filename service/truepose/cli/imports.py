"""The command that makes a campaign of points from other software. Heavy imports wait until it runs."""

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import Json
from truepose.cli.output import print_json, print_lines
from truepose.domain.errors import ConfigurationError

if TYPE_CHECKING:
    from truepose.exchange.point_lists.joined import Joined

_NAMED = 5  # of those that are left over


class LengthUnit(StrEnum):
    """What the coordinates of a list are in."""

    MM = "mm"
    CM = "cm"
    M = "m"
    IN = "in"


def import_command(
    points: Annotated[Path, typer.Argument(help="Points as a tracker's own software exports them (text).")],
    joints: Annotated[
        Path,
        typer.Argument(help="Joint angles (CSV): config, q1_deg.., perhaps nest, dir1.., time_s, point."),
    ],
    robot: Annotated[str, typer.Option(help="Shipped robot, or a file of one's own (.toml, .urdf).")],
    out: Annotated[Path, typer.Option(help="Campaign folder to write.")],
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
    json: Json = False,
) -> int:
    """Make a campaign folder of a list of points and the joint angles at which they were read.

    Example: truepose import points.txt joints.csv --robot abb-irb-120 --unit mm --u-mm 0.03 --out mine
    """
    from truepose.exchange.campaigns.folder import write_campaign
    from truepose.exchange.point_lists.importing import Stated, import_points

    if out.exists() and any(out.iterdir()):
        raise ConfigurationError(f"{out} is not empty: name another folder.")
    centres = [_centre(text) for text in nest or ()]
    stated = Stated(robot, unit and unit.value, u_mm, names, centres, nest_u_mm)
    campaign, found = import_points(points, joints, stated)
    write_campaign(campaign, out)
    if json:
        left = {"points": list(found.points_alone), "lines": list(found.rows_alone)}
        print_json({"campaign": str(out), "readings": len(found), "left_over": left})
    else:
        print_lines([f"{out}: {len(found)} points at their joint angles.", *_left_over(found, joints.name)])
    return 0


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
