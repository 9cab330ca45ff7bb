"""A Leica AT401 as its emScon server shows it on the wire."""

from truepose_simulators.instruments.tracker.leica_emscon.server import tracker_endpoint

__all__ = ["tracker_endpoint"]
