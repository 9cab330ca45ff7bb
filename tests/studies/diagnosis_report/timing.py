"""How long one diagnosis takes on one core.

`python -m tests.studies.diagnosis_report.timing FOLDER` prints the seconds for one campaign folder: in a
process of its own a diagnosis that takes far too long can be ended.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType
from typing import Final

from tests.studies.diagnosis_report.recorder import running_recorder
from tests.studies.report_command import target_row
from truepose.diagnosis.diagnose import diagnose
from truepose.exchange.campaigns.folder import read_campaign
from truepose.reports.table_report import Row, Section

_LIMITS_S: Final = MappingProxyType({100: 1.0, 1_000: 3.0, 10_000: 15.0})
_PATIENCE: Final = 10.0  # times the limit
_SCENARIOS: Final = ("irb120-tilted", "irb120-everyday")  # nothing to find, and more than anything to find
_CURVES: Final = ("irb120-curves", 2_000, 6.0)
_ONE_CORE: Final = MappingProxyType({"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"})


def timing_section() -> Section:
    """Diagnose campaigns of each size; raises RecorderFailedError."""
    return Section("Time of one diagnosis, all effects, one core", tuple(_rows()))


def _rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder, running_recorder() as recorder:
        cases = [(scenario, *limit) for limit in _LIMITS_S.items() for scenario in _SCENARIOS]
        for scenario, size, limit_s in (*cases, _CURVES):
            recorder.record(scenario, "--out", folder, "--configurations", str(size))
            yield _row(f"{scenario}, {size:,} readings", Path(folder), limit_s)


def _row(figure: str, campaign: Path, limit_s: float) -> Row:
    command = [sys.executable, "-m", "tests.studies.diagnosis_report.timing", str(campaign)]
    target, patience_s = f"<= {limit_s:g} s", _PATIENCE * limit_s
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=True,
            timeout=patience_s,
            env={**os.environ, **_ONE_CORE},
        )
    except subprocess.TimeoutExpired:
        return target_row(figure, target, f"ended after {patience_s:g} s", good=False)
    taken_s = float(done.stdout)
    return target_row(figure, target, f"{taken_s:.1f} s", taken_s <= limit_s)


def _main(folder: Path) -> None:
    campaign = read_campaign(folder)
    began_s = time.perf_counter()
    diagnose(campaign)
    sys.stdout.write(f"{time.perf_counter() - began_s:.3f}\n")


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
