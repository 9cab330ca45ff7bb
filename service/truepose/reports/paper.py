"""A report as a file: written, or printed as a PDF in the colours of paper, tagged, with nothing fetched.

ReportsError
├── UnwritableReportError   the file cannot be written
└── NoPdfError              the machine lacks what a PDF is made with
"""

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from truepose.domain.errors import TrueposeError


class ReportsError(TrueposeError):
    """Base of every error of this package."""


class UnwritableReportError(ReportsError):
    """The report cannot be written where it should go."""


class NoPdfError(ReportsError):
    """The machine lacks what a PDF is made with."""


# What the screen's variables are on paper, for the printer of a browser and for ours.
PAPER: Final = {
    "paper": "#ffffff",
    "card": "#ffffff",
    "ink": "#000000",
    "muted": "#444444",
    "grid": "#dddddd",
    "line": "#bbbbbb",
    "edge": "#444444",
    "accent": "#0b4f60",
    "before": "#c56f14",
    "after": "#14606f",
    "noise": "#55398a",
    "axis-x": "#b0301f",
    "axis-y": "#1f6b30",
    "axis-z": "#1f4f9f",
    "good": "#14602f",
    "bad": "#9b1c15",
    "warn": "#6b4500",
    "warn-back": "#ffffff",
    "warn-shape": "#8a5a00",
}
_VARIABLE: Final = re.compile(r'="var\(--([a-z-]+)\)"')


def pdf_of(html: str) -> bytes:
    """Return a self-contained page as a PDF.

    Raises
    ------
    NoPdfError
        The machine lacks the library that sets text.
    """
    require_pdf()
    with _without_remarks():
        from weasyprint import HTML
        from weasyprint.urls import URLFetcher

        # Figures are attributes, to which the printer's style sheets do not reach.
        coloured = _VARIABLE.sub(lambda variable: f'="{PAPER[variable[1]]}"', html)
        page = HTML(string=coloured, url_fetcher=URLFetcher(allowed_protocols=["data"]))
        return bytes(page.write_pdf(pdf_tags=True))


def require_pdf() -> None:
    """Refuse before a report is made what could not be printed after it; raises NoPdfError."""
    try:
        with _without_remarks():
            import weasyprint  # noqa: F401  # it looks for the libraries of the system when it is imported
    except OSError as error:
        raise NoPdfError(
            "A PDF needs the Pango library, which is not installed on this computer. Install it"
            " (Debian and Ubuntu: apt-get install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0;"
            " macOS: brew install pango; Windows: mingw-w64-ucrt-x86_64-pango from MSYS2), or use the .html."
        ) from error


@contextlib.contextmanager
def _without_remarks() -> Iterator[None]:
    """Silence what the printer says of libraries and fonts: programs read the output it would stand in.

    That an older library will not do for a later version of it concerns nobody who reads a report.
    """
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield


def write_report_text(path: Path, html: str) -> None:
    """Write a page into a file, making its folder where needed: as a PDF where its name ends in `.pdf`.

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    NoPdfError
        It should be a PDF, and the machine lacks the library that sets text.
    """
    body = pdf_of(html) if is_pdf(path) else html.encode()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(body)
    except OSError as error:
        raise UnwritableReportError(
            f"The report cannot be written to {path} ({error.strerror}). Choose another file."
        ) from error


def is_pdf(path: Path) -> bool:
    """Return whether a file of that name is to be a PDF."""
    return path.suffix.lower() == ".pdf"


def print_page(page: Path) -> None:
    """Write a page that is a file as a PDF beside it; raises what `write_report_text` raises."""
    write_report_text(page.with_suffix(".pdf"), page.read_text(encoding="utf-8"))
