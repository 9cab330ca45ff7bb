"""Errors of starting a service.

StartError
├── SimulationFailedError   the simulated cell did not come up
│   └── ScenarioRefusedError    it refuses the scenario that it should be
├── UnsafeStartError        it would let in whoever reaches it, or speak TLS with what is no certificate
└── PortInUseError          somebody listens at that address already
"""

from truepose.domain.errors import TrueposeError


class StartError(TrueposeError):
    """Base of every error of starting a service."""


class SimulationFailedError(StartError):
    """The simulated cell did not come up."""


class ScenarioRefusedError(SimulationFailedError):
    """The simulated cell refuses the scenario that it should be."""


class UnsafeStartError(StartError):
    """The service would let in whoever reaches it, or speak TLS with what is no certificate."""


class PortInUseError(StartError):
    """Somebody listens at that address already, or it is not ours to listen at."""
