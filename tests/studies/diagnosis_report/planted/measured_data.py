"""Campaigns measured on real robots, whose folder the environment variable TRUEPOSE_DATA names."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.studies.report_command import campaigns_folder, target_row, without_data
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.diagnosis import Cause, Confidence, Diagnosis, Finding
from truepose.exchange.campaigns.folder import read_campaign
from truepose.reports.table_report import Row, Section

_WITHOUT_SPRINGS: Final = ("base", "tool", "geometry")
_TIMES_SMALLER: Final = 2.5


@dataclass(frozen=True, slots=True)
class _Expected:
    """What one campaign should give from one start."""

    folder: str
    start: tuple[str, ...] | None
    target: str
    met: Callable[[Diagnosis], bool]


def measured_section() -> Section:
    """Diagnose every campaign, or say that there is none."""
    title = "Measured data of real robots"
    folder = campaigns_folder()
    if folder is None:
        return without_data(title)
    return Section(title, tuple(_row(folder, expected) for expected in _EXPECTED))


def _row(folder: Path, expected: _Expected) -> Row:
    diagnosis = diagnose(read_campaign(folder / expected.folder), expected.start)
    start = "default start" if expected.start is None else "from " + ", ".join(expected.start)
    figure = f"{expected.folder}, {start}"
    return target_row(figure, expected.target, _said(diagnosis), expected.met(diagnosis))


def _said(diagnosis: Diagnosis) -> str:
    ratio = times_smaller(diagnosis)
    names = "; ".join(_named(finding) for finding in diagnosis.all_findings) or "no finding"
    return f"{diagnosis.verdict.value}: {names}; held-out RMS {ratio:.2f} times smaller"


def _named(finding: Finding) -> str:
    rivals = ", ".join(f"{cause.effect} {cause.subject}" for cause in finding.confusable_with)
    return (
        f"{finding.effect} {finding.subject} ({finding.confidence.value}{', or ' if rivals else ''}{rivals})"
    )


def times_smaller(diagnosis: Diagnosis) -> float:
    """Return how many times smaller the held-out RMS is with the extension."""
    if diagnosis.before is None or diagnosis.after is None:
        return float("nan")
    return diagnosis.before.rms_mm / diagnosis.after.rms_mm


def springs_with_rivals(diagnosis: Diagnosis) -> bool:
    """Whether a spring is named, with rivals, and predicts held-out points much better.

    The arm of these campaigns is always stretched: springs of several joints and a wave of joint 2 that
    comes once per turn look alike, which an honest answer says.
    """
    springs = [finding for finding in diagnosis.all_findings if finding.effect == "compliance"]
    return (
        bool(springs)
        and all(finding.confusable_with for finding in springs)
        and times_smaller(diagnosis) >= _TIMES_SMALLER
    )


def nothing_certain(diagnosis: Diagnosis) -> bool:
    """Whether no name is called certain."""
    return all(finding.confidence is not Confidence.CERTAIN for finding in diagnosis.all_findings)


def springs_at_most_likely(diagnosis: Diagnosis) -> bool:
    """Whether springs of joints 2 and 3 are not called certain, and nothing else is named."""
    allowed = {Cause("compliance", subject) for subject in ("joint 2", "joint 3", "joints")}
    named = {Cause(finding.effect, finding.subject) for finding in diagnosis.all_findings}
    return named <= allowed and nothing_certain(diagnosis)


_EXPECTED: Final = (
    *(
        _Expected(
            name, _WITHOUT_SPRINGS, "compliance with rivals, RMS >= 2.5 times smaller", springs_with_rivals
        )
        for name in ("iiwa7-0kg", "iiwa7-1p25kg", "iiwa7-2p5kg")
    ),
    *(
        _Expected(name, None, "no certain name", nothing_certain)
        for name in ("iiwa7-0kg", "iiwa7-1p25kg", "iiwa7-2p5kg")
    ),
    *(
        _Expected(name, None, "no certain name", nothing_certain)
        for name in ("motoman-left", "motoman-right")
    ),
    _Expected(
        "fanuc-r2000", _WITHOUT_SPRINGS, "compliance of joints 2, 3 at most likely", springs_at_most_likely
    ),
)
