"""What the commands on campaign folders share: names of effects, campaigns in, files out."""

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.output import remark
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import LANGUAGES

if TYPE_CHECKING:
    from truepose.domain.campaign import Campaign


def _spoken(language: str) -> str:
    if language not in LANGUAGES:
        raise typer.BadParameter(f"unsupported language: {language}; choose from {', '.join(LANGUAGES)}")
    return language


CampaignPath = Annotated[Path, typer.Argument(help="Campaign folder, or its zip file.")]
ModelFile = Annotated[Path, typer.Argument(help="Model file written by `identify --model-out`.")]
Effects = Annotated[str, typer.Option(help="`auto`, or names separated by commas, e.g. base,tool,geometry.")]
Language = Annotated[
    str,
    typer.Option(
        metavar="|".join(LANGUAGES),
        callback=_spoken,
        help="Language of sentences, tables and reports; JSON stays in English.",
    ),
]
ReportFile = Annotated[
    Path | None, typer.Option(help="Write a self-contained report here: .html, or .pdf to print and sign.")
]
LimitMm = Annotated[float | None, typer.Option(help="Largest error that passes.")]
UMm = Annotated[
    float | None,
    typer.Option(
        "--u-mm", min=1e-6, help="Standard uncertainty of each reading [mm], if no column states it."
    ),
]
MaxShiftMm = Annotated[
    float | None,
    typer.Option(
        help="Largest tool shift accepted from the model (default: 20 mm for an unedited file, else 5 mm)."
    ),
]
AcceptEdited = Annotated[
    bool, typer.Option("--accept-edited", help="Accept a model file that was edited after truepose wrote it.")
]
Workers = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBER|dask|dask://HOST:PORT",
        help="Number of processes, `dask` for this computer, or the address of a Dask scheduler.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document and nothing else.")]


def effect_names(effects: str) -> tuple[str, ...] | None:
    """Return the names that `--effects` gives, None for `auto`; raises ConfigurationError for none at all."""
    if effects.strip() == "auto":
        return None
    names = tuple(name.strip() for name in effects.split(",") if name.strip())
    if not names:
        raise ConfigurationError(
            "--effects is empty: give `auto`, or names separated by commas, such as base,geometry."
        )
    return names


def require_limit(limit_mm: float | None) -> None:
    """Refuse a limit that nothing can be held against."""
    if limit_mm is not None and not 0.0 < limit_mm < math.inf:
        raise ConfigurationError(f"--limit-mm {limit_mm:g}: give the largest error that passes, above 0 mm.")


def require_folders(*files: Path | None) -> None:
    """Refuse before the work is done what could not be written after it."""
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise ConfigurationError(f"{file}: the folder {file.parent} does not exist; create it first.")
        if file is not None and file.is_dir():
            raise ConfigurationError(f"{file} is a folder; give the name of a file.")
        if file is not None and file.suffix.lower() == ".pdf":
            _require_pdf()


def _require_pdf() -> None:
    from truepose.reports.paper import require_pdf

    require_pdf()


@contextlib.contextmanager
def writing(file: Path) -> Iterator[None]:
    """Turn a file that cannot be written into a sentence."""
    try:
        yield
    except OSError as error:
        raise ConfigurationError(
            f"{file} cannot be written ({error.strerror}); choose another file."
        ) from error


def read_measured(path: Path) -> "Campaign":
    """Read a campaign folder or the zip of one, and say which installed causes will not look at it.

    Heavy imports wait until then.
    """
    from truepose.effects.registry import unusable_causes
    from truepose.exchange.campaigns.zip_file import read_campaign_at

    remark(unusable_causes())
    return read_campaign_at(path)
