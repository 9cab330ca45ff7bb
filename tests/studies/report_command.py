"""What the commands of the reports share: their options, what they print, how they end."""

import argparse
import os
import sys
from collections.abc import Iterable
from pathlib import Path

from truepose.reports.table_report import Row, Section, Verdict, write_table_report


def campaigns_folder() -> Path | None:
    """Return where campaigns of real robots are; None where TRUEPOSE_DATA names no folder."""
    folder = Path(os.environ.get("TRUEPOSE_DATA") or "-") / "campaigns"
    return folder if folder.is_dir() else None


def without_data(title: str) -> Section:
    """Return the section that says that there are no such campaigns."""
    return Section(title, (Row("all", "", "TRUEPOSE_DATA names no folder", Verdict.NOT_MEASURED),))


def shown(sections: Iterable[Section]) -> list[Section]:
    """Print each section once it is there, and return them all."""
    told = []
    for section in sections:
        _print(section)
        told.append(section)
    return told


def _print(section: Section) -> None:
    figures, targets, measured = (
        max((len(getattr(row, name)) for row in section.rows), default=0)
        for name in ("figure", "target", "measured")
    )
    sys.stdout.write(f"\n{section.title}\n")
    for row in section.rows:
        columns = f"{row.figure:{figures}s}  {row.target:>{targets}s}  {row.measured:{measured}s}"
        sys.stdout.write(f"  {columns}  {row.verdict.value}\n")
    if section.note:
        sys.stdout.write(f"  {section.note}\n")
    sys.stdout.flush()


def target_row(figure: str, target: str, measured: str, good: bool) -> Row:
    """Return a figure that reaches its target or misses it."""
    return Row(figure, target, measured, Verdict.PASSED if good else Verdict.FAILED)


def informing(figure: str, measured: str) -> Row:
    """Return a figure without a target."""
    return Row(figure, "", measured, Verdict.NO_TARGET)


def report(sections: Iterable[Section], file: Path, title: str) -> int:
    """Print sections and write them as a page; return 1 where a target is missed."""
    told = shown(sections)
    write_table_report(file, title, told, simulated=True)
    return status_of(told)


def status_of(sections: Iterable[Section]) -> int:
    """Return 1 where a target is missed."""
    return int(any(row.verdict is Verdict.FAILED for section in sections for row in section.rows))


def count(text: str) -> int:
    """Read a number from 1."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{number} is not 1 or more")
    return number


def add_sections(parser: argparse.ArgumentParser, known: tuple[str, ...]) -> None:
    """Add `--sections`: some of those that are known, all where it is not given."""

    def chosen(text: str) -> tuple[str, ...]:
        keys = tuple(text.split(","))
        unknown = [key for key in keys if key not in known]
        if unknown:
            raise argparse.ArgumentTypeError(f"no section {', '.join(unknown)}; known: {', '.join(known)}")
        return keys

    names = f"only these, with commas between them: {', '.join(known)}"
    parser.add_argument("--sections", type=chosen, default=known, help=names)
