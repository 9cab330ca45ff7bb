"""What the simulated controller refuses."""

from truepose_simulators.errors import SimulatorError


class RefusedError(SimulatorError):
    """The controller refuses with a number."""

    def __init__(self, error: int, shown: str = "") -> None:
        super().__init__(shown or f"error {error}")
        self.error = error
        self.shown = shown  # on its pendant
