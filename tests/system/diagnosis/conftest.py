"""What the diagnosis of a recorded campaign says."""

from tests.helpers.diagnosis.recorded_trials import diagnosed, recorder

__all__ = ["diagnosed", "recorder"]
