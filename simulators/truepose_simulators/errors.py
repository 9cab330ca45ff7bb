"""Errors of the simulated cell; each text is one sentence for whoever started it.

SimulatorError
├── ScenarioError            a scenario file cannot be used: file, key, what to do
├── ModelError               an identified model cannot be simulated: file, key or effect
├── ReplayError              a campaign folder cannot be replayed: file, column, what to do
├── JournalError             what was done in a cell cannot be kept or read: file, line, what to do
├── EndpointUnavailableError an endpoint cannot listen at its address
├── TruthRequestError        a request to the truth endpoint makes no sense
├── ArmStoppedError          an emergency stop or a protective stop holds the arm
├── HandsError               the simulated person cannot do what is asked
└── BeamError                the tracker has nothing to measure
    ├── NoTargetError          no reflector is locked on
    └── BeamBrokenError        the beam was lost while measuring
"""


class SimulatorError(Exception):
    """Base of everything the simulators raise on purpose."""


class ScenarioError(SimulatorError):
    """A scenario cannot be used."""


class ModelError(SimulatorError):
    """An identified model cannot be simulated."""


class ReplayError(SimulatorError):
    """A campaign folder cannot be replayed."""


class JournalError(SimulatorError):
    """What was done in a cell cannot be kept, or cannot be done again."""


class EndpointUnavailableError(SimulatorError):
    """An endpoint cannot listen at its address."""


class TruthRequestError(SimulatorError):
    """A request to the truth endpoint makes no sense."""


class ArmStoppedError(SimulatorError):
    """A stop holds the arm."""


class HandsError(SimulatorError):
    """The simulated person cannot do what is asked."""


class BeamError(SimulatorError):
    """The tracker has nothing to measure."""


class NoTargetError(BeamError):
    """No reflector is locked on."""


class BeamBrokenError(BeamError):
    """The beam was lost while measuring."""
