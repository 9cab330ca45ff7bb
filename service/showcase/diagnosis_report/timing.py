"""How long one diagnosis of many readings takes on all cores."""

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType
from typing import Final

from service.diagnosis.diagnose import diagnose
from service.exchange.campaign_folder import read_campaign
from service.reports.table_report import Row, Section, Verdict
from service.showcase.diagnosis_report.recorder import running_recorder

_LIMITS_S: Final = MappingProxyType({1_000: 10.0, 10_000: 60.0})
_SCENARIO: Final = "irb120-everyday"  # many findings: the longest answer


def timing_section() -> Section:
    """Diagnose one campaign of each size; raises RecorderFailedError."""
    return Section(f"Time of one diagnosis, {_SCENARIO}, all effects, all cores", tuple(_rows()))


def _rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder, running_recorder() as recorder:
        for size, limit_s in _LIMITS_S.items():
            recorder.record(_SCENARIO, "--out", folder, "--configurations", str(size))
            campaign = read_campaign(Path(folder))
            began_s = time.perf_counter()
            diagnose(campaign)
            taken_s = time.perf_counter() - began_s
            verdict = Verdict.PASSED if taken_s <= limit_s else Verdict.FAILED
            yield Row(f"{size:,} readings", f"<= {limit_s:g} s", f"{taken_s:.1f} s", verdict)
