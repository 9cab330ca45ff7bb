"""Simulated campaigns, in folders as an archive has them."""

from collections.abc import Sequence
from pathlib import Path

from truepose.analysis.archive import ArchivedCampaign, in_folder
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario


def recorded_archive(
    folder: Path, campaigns: int, readings: int, scenarios: Sequence[str]
) -> list[ArchivedCampaign]:
    """Return so many campaigns, recorded where they are not there yet."""
    loaded = [load_scenario(name) for name in scenarios]
    for number in range(campaigns):
        out = folder / f"{number:05d}"
        if not (out / "truth.json").exists():
            write_campaign(record(loaded[number % len(loaded)], number, RecordingRequest(readings, 0)), out)
    return in_folder(folder)[:campaigns]
