"""Campaigns recorded from the simulated cell without a wire, for studies that need very many of them."""

from truepose_simulators.recording.campaign import Points, Readings, Recording, References, record
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import NoStopsError, RecordingRequest, Stops

__all__ = [
    "NoStopsError",
    "Points",
    "Readings",
    "Recording",
    "RecordingRequest",
    "References",
    "Stops",
    "record",
    "write_campaign",
]
