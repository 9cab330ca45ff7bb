"""The command line of a study of the storage."""

import argparse
import asyncio
import json
import sys
import tempfile
from collections.abc import Callable, Coroutine
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

Found = TypeVar("Found")


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
    options = _options(document, usual)
    out = options.pop("out")
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out) as folder:
        found = asyncio.run(study(Path(folder), **options))
    (out / f"{name}.json").write_text(json.dumps(vars(found), default=asdict, indent=1))
    sys.stdout.write(told(found))


def _options(document: str | None, usual: dict[str, float]) -> dict[str, Any]:
    parser = argparse.ArgumentParser(
        description=document, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    for option, value in usual.items():
        parser.add_argument(f"--{option.replace('_', '-')}", type=type(value), default=value)
    return vars(parser.parse_args())
