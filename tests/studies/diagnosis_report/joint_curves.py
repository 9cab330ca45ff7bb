"""Joints that are off by dozens of lines without a gear ratio: the scenario `irb120-curves`.

Held-out errors are compared with the noise that the held-out readings truly have. The curve of a joint is
compared with the true one but for its mean, which is the joint's zero.
"""

import json
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from tests.studies.diagnosis_report.recorder import Recorder, running_recorder
from tests.studies.report_command import target_row
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign
from truepose.domain.diagnosis import Diagnosis, Finding
from truepose.exchange.campaigns.folder import read_campaign
from truepose.reports.table_report import Row, Section

_SCENARIO: Final = "irb120-curves"
_HARMONICS: Final = "joint_harmonics"
_JOINTS: Final = frozenset({"joint 1", "joint 2", "joint 3"})
_LIMITS: Final = MappingProxyType({500: 1.06, 1_000: 1.02, 2_000: 1.015})  # of the noise, by readings
_COVERED: Final = (0.90, 0.98)
_SEEDS: Final = 5
_VALIDATION: Final = 1_000


@dataclass(frozen=True, slots=True)
class _Seen:
    """One diagnosis beside the truth."""

    named: bool  # the joints that are off, and nothing else
    rms_mm: float  # held out
    noise_mm: float  # RMS that the held-out readings truly have
    covered: float  # share of the curves within their 95 % bands


def joint_curves_section(first_seed: int) -> Section:
    """Diagnose campaigns of each size; raises RecorderFailedError."""
    with tempfile.TemporaryDirectory() as folder, running_recorder() as recorder:
        rows = tuple(
            row
            for readings, limit in _LIMITS.items()
            for row in _rows(readings, limit, _campaigns(recorder, Path(folder), readings, first_seed))
        )
    return Section(f"Joints off by curves ({_SCENARIO}, {_SEEDS} campaigns a size)", rows)


def _campaigns(recorder: Recorder, folder: Path, readings: int, first_seed: int) -> Iterator[_Seen]:
    sizes = ("--configurations", str(readings), "--validation", str(_VALIDATION))
    for seed in range(first_seed, first_seed + _SEEDS):
        recorder.record(_SCENARIO, "--seed", str(seed), "--out", str(folder), *sizes)
        truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
        campaign = read_campaign(folder)
        yield judged(diagnose(campaign), campaign, truth)


def judged(found: Diagnosis, campaign: Campaign, truth: Mapping[str, Any]) -> _Seen:
    """Hold a diagnosis against what is true in the cell."""
    named = {(one.effect, one.subject) for one in found.all_findings}
    rms_mm = float("nan") if found.after is None else found.after.rms_mm
    return _Seen(
        named={_HARMONICS} == {effect for effect, _ in named}
        and {subject for _, subject in named} == _JOINTS,
        rms_mm=rms_mm,
        noise_mm=_noise_mm(campaign, truth),
        covered=_covered(found, truth["effects"]),
    )


def _noise_mm(campaign: Campaign, truth: Mapping[str, Any]) -> float:
    if campaign.validation is None:
        return float("nan")
    off_mm = campaign.validation.position_mm - np.array(truth["true_positions_mm"]["validation"])
    return float(np.sqrt((off_mm**2).sum(axis=1).mean()))


def _covered(found: Diagnosis, effects: Sequence[Mapping[str, Any]]) -> float:
    """Return the share of all curves found that lies within the stated bands."""
    within = [_within(finding, effects) for finding in found.all_findings if finding.effect == _HARMONICS]
    return float(np.concatenate(within).mean()) if within else float("nan")


def _within(finding: Finding, effects: Sequence[Mapping[str, Any]]) -> FloatArray:
    curve = finding.curve
    if curve is None:
        return np.zeros(1)
    true_deg = sum(
        line["amplitude"] * np.sin(np.radians(line["order"] * curve.line_x + line["phase_deg"]))
        for line in effects
        if (line["name"], line["subject"]) == (_HARMONICS, finding.subject)
    )
    off_deg = curve.line - true_deg
    return np.asarray(np.abs(off_deg - off_deg.mean()) <= curve.line_band, dtype=float)


def _rows(readings: int, limit: float, campaigns: Iterator[_Seen]) -> Iterator[Row]:
    every = list(campaigns)
    named = sum(one.named for one in every)
    ratio = float(np.mean([one.rms_mm / one.noise_mm for one in every]))
    covered = float(np.mean([one.covered for one in every]))
    low, high = _COVERED
    yield target_row(
        f"{readings:,} readings: the joints named, no other", f"{_SEEDS}", f"{named}", named == _SEEDS
    )
    yield target_row(
        f"{readings:,} readings: held-out RMS over noise", f"<= {limit:g}", f"{ratio:.3f}", ratio <= limit
    )
    yield target_row(
        f"{readings:,} readings: curves within their 95 % band",
        f"{100 * low:g}-{100 * high:g} %",
        f"{100 * covered:.1f} %",
        low <= covered <= high,
    )
