"""The command line of a study: its options, where it leaves what it found, and what it says of that."""

import argparse
import asyncio
import json
import sys
import tempfile
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

Found = TypeVar("Found")


def study_parser(document: str | None, **options: object) -> argparse.ArgumentParser:
    """Return what reads the options of a study.

    Parameters
    ----------
    document : str or None
        What the study is for; of its module.
    **options : value, type, or tuple of one and a sentence
        Each by its name: what it is where nobody says otherwise, a type where somebody has to say it, and
        what help tells of it. One that is False is a switch.
    """
    parser = argparse.ArgumentParser(
        description=document, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name, option in options.items():
        usual, said = option if isinstance(option, tuple) else (option, None)
        flag = f"--{name.replace('_', '-')}"
        if usual is False:
            parser.add_argument(flag, action="store_true", help=said)
        elif isinstance(usual, type):
            parser.add_argument(flag, type=usual, required=True, help=said)
        else:
            parser.add_argument(flag, type=type(usual), default=usual, help=said)
    return parser


def study_options(
    document: str | None, arguments: Sequence[str] | None = None, **options: object
) -> argparse.Namespace:
    """Return the options of a study as somebody gave them; raises SystemExit."""
    return study_parser(document, **options).parse_args(arguments)


def leave(out: Path, name: str, found: object) -> None:
    """Write what was found as `name`.json into a folder, which is made where needed."""
    out.mkdir(parents=True, exist_ok=True)
    (out / f"{name}.json").write_text(json.dumps(found, default=asdict, indent=1), encoding="utf-8")


def from_command_line(
    document: str | None,
    name: str,
    study: Callable[..., Coroutine[Any, Any, Found]],
    told: Callable[[Found], str],
    **usual: float,
) -> None:
    """Run a study with the options of the command line; what it found is in NAME.json and said in words.

    Parameters
    ----------
    document : str or None
        What the study is for; of its module.
    name : str
    study : coroutine function
        Is given a folder that is removed afterwards, and the options.
    told : callable
        Returns what was found in words.
    **usual : float
        The options, and what they are where nobody says otherwise.
    """
    options = vars(study_options(document, out=Path, **usual))
    out = options.pop("out")
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out) as folder:
        found = asyncio.run(study(Path(folder), **options))
    leave(out, name, vars(found))
    sys.stdout.write(told(found))
