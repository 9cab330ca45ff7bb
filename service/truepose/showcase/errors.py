"""Errors of the showcase runs.

ShowcaseError
├── UnusableScenarioError   the service refuses the cell that it was asked for
├── ServiceFailedError      the service did not start, or does not answer any more
├── RequestRefusedError     the service answered a request with a problem
├── SessionHaltedError      a session paused or ended before everything was measured
├── JobFailedError          a job ended without a result
├── TruthUnknownError       the simulated cell did not tell its truth
├── RecorderFailedError     the recorder of simulated campaigns refuses or has ended
└── NothingHappenedError    chance let a planted effect hit none of the readings
"""

from truepose.domain.errors import TrueposeError


class ShowcaseError(TrueposeError):
    """Base of every error of the showcase runs."""


class UnusableScenarioError(ShowcaseError):
    """The service refuses the cell that it was asked for."""


class ServiceFailedError(ShowcaseError):
    """The service did not start, or does not answer any more."""


class RequestRefusedError(ShowcaseError):
    """The service answered a request with a problem."""


class SessionHaltedError(ShowcaseError):
    """A session paused or ended before everything was measured."""


class JobFailedError(ShowcaseError):
    """A job ended without a result."""


class TruthUnknownError(ShowcaseError):
    """The simulated cell did not tell its truth."""


class RecorderFailedError(ShowcaseError):
    """The recorder of simulated campaigns refuses a request, or has ended."""


class NothingHappenedError(ShowcaseError):
    """Chance let a planted effect hit none of the readings, however often it was tried."""
