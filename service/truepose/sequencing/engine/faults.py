"""What a fault of a device means to any session."""

from truepose_drivers.errors import (
    ConfigurationError,
    DeviceRefusedError,
    DriverError,
    MeasurementFailedError,
    NotInitialisedError,
)


def is_interruption(error: Exception) -> bool:
    """Whether devices have to be opened anew: the link, nonsense on it, or a driver that failed."""
    if isinstance(error, NotInitialisedError):
        return True
    spoken = MeasurementFailedError | DeviceRefusedError | ConfigurationError
    return isinstance(error, DriverError) and not isinstance(error, spoken)
