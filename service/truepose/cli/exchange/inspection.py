"""The command that shows what other programs' files say."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.exchange.files import Json
from truepose.cli.output import print_json, print_lines

if TYPE_CHECKING:
    from truepose.exchange.ballbar_result import BallbarResult
    from truepose.exchange.json_text import Json as JsonValue

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
    "The raw readings are in an element whose form is not public; they were not read, and no length for a"
    " calibration can be taken from this file."
)


def inspect_command(
    result: Annotated[Path, typer.Argument(help="Result file of a Renishaw QC20-W (.b5r).")],
    json: Json = False,
) -> int:
    """Show what a result file of a Renishaw QC20-W says: test, machine, ballbar, features.

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
