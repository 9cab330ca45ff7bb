"""Errors of the analysis.

AnalysisError
├── SessionsDifferError    two sessions were not measured with the same robot and set-up
├── RoleError              readings kept for validation would identify, or judge what they identified
├── NothingMeasuredError   a session or campaign holds no reading of the kind that is asked for
├── NeverDiagnosedError    no diagnosis of that robot is stored
├── RobotsMixedError       diagnoses of several robots would be compared as if they were of one
├── NotReadyError          of what was brought something is asked still
├── BusyError              too many ask for the same at once
├── WorkerDiedError        the worker process ended without an answer
└── ClusterError           the workers that many tasks are given to cannot be used
    ├── WorkersUnlikeError     a worker computes with other versions, or another processor's arithmetic
    └── PartFailedError        one of many parts has no answer
"""

from truepose.domain.errors import TrueposeError


class AnalysisError(TrueposeError):
    """Base of every error of the analysis."""


class SessionsDifferError(AnalysisError):
    """Two sessions were not measured with the same robot and set-up."""


class RoleError(AnalysisError):
    """Readings kept for validation would identify, or would judge the model that they identified."""


class NothingMeasuredError(AnalysisError):
    """A session or campaign holds no reading of the kind that is asked for."""


class NeverDiagnosedError(AnalysisError):
    """No diagnosis of that robot is stored."""


class RobotsMixedError(AnalysisError):
    """Diagnoses of several robots would be compared as if they were of one."""


class NotReadyError(AnalysisError):
    """Of what was brought something is asked still, or cannot be read."""


class BusyError(AnalysisError):
    """Too many ask for the same at once; whoever asks again later gets it."""

    retry_after_s = 10


class WorkerDiedError(AnalysisError):
    """The worker process ended without an answer."""


class ClusterError(AnalysisError):
    """The workers that many tasks are given to cannot be used, or are lost for good."""


class WorkersUnlikeError(ClusterError):
    """A worker computes with other versions or another arithmetic: its results would differ in their bits."""


class PartFailedError(ClusterError):
    """One of many parts has no answer, and without it the others are of no use."""
