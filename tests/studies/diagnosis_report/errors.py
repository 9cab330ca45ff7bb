"""Errors of the power studies."""


class RecorderFailedError(Exception):
    """The recorder of simulated campaigns refuses a request, or has ended."""


class NothingHappenedError(Exception):
    """Chance let a planted effect hit none of the readings, however often it was tried."""
