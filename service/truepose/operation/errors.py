"""Errors of operating a cell.

OperationError
├── UnknownDeviceError   the cell has no device of that name
├── MissingDeviceError   a session needs a kind of device that the cell file does not list
├── DeviceInUseError     a session holds the device
├── CellChangedError     the cell file says something else than the service was started with
├── NoBallbarError       the cell file does not describe a ballbar
├── FaultRefusedError    a simulated cell cannot have that go wrong
├── RealCellError        only a simulated cell can be asked that
└── CertificateError     a certificate does not hold, and nobody says why that may be passed over
"""

from truepose.domain.errors import TrueposeError


class OperationError(TrueposeError):
    """Base of every error of operating a cell."""


class UnknownDeviceError(OperationError):
    """The cell has no device of that name."""


class MissingDeviceError(OperationError):
    """A session needs a kind of device that the cell file does not list."""


class DeviceInUseError(OperationError):
    """A session holds the device."""


class CellChangedError(OperationError):
    """The cell file says something else than the service was started with."""


class NoBallbarError(OperationError):
    """The cell file does not describe a ballbar."""


class FaultRefusedError(OperationError):
    """A simulated cell cannot have that go wrong."""


class RealCellError(OperationError):
    """Only a simulated cell can be asked that."""


class CertificateError(OperationError):
    """A certificate does not hold, and nobody says why that may be passed over."""
