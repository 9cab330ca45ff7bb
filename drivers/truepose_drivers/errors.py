"""Errors of drivers; the operator reads their text.

DriverError
├── ConfigurationError         the cell file asks for something this driver cannot be
├── LinkError                  the connection
│   ├── ConnectFailedError       nobody answers at that address
│   ├── ConnectionLostError      it was there and is gone
│   └── NoReplyError             it is there and says nothing
├── RemoteProtocolError        the device said something the protocol does not know
│   └── ImplausibleReadingError  it said something that no instrument of its kind can mean
├── DriverFaultError           the driver itself failed, with an error that is none of these
├── DeviceRefusedError         the device understood and refused
│   ├── NotInitialisedError      it must be initialised first
│   ├── BusyError                it is doing something else
│   └── TargetRefusedError       a joint target is outside what the robot accepts
└── MeasurementFailedError     the instrument tried and could not
    ├── BeamBrokenError          the line of sight was interrupted
    ├── ReflectorNotFoundError   no reflector where it was looked for
    ├── ArtefactNotSeenError     the camera does not see enough of the artefact
    └── OutOfVolumeError         the artefact stands where the camera does not measure
"""


class DriverError(Exception):
    """Base of every driver error; says what happened and what the operator can do."""


class ConfigurationError(DriverError):
    """The cell file asks for something this driver cannot be."""


class LinkError(DriverError):
    """The connection to the device is in trouble."""


class ConnectFailedError(LinkError):
    """Nobody answers at that address. Operator: check power, cable and address."""


class ConnectionLostError(LinkError):
    """The connection was there and is gone. Operator: check the cable, then confirm before anything moves."""


class NoReplyError(LinkError):
    """The device is connected and says nothing within the time allowed."""


class RemoteProtocolError(DriverError):
    """The device sent something that its protocol does not know."""


class ImplausibleReadingError(RemoteProtocolError):
    """The device sent a reading that no instrument of its kind can mean."""


class DriverFaultError(DriverError):
    """The driver failed with an error that is none of a driver; its link was closed."""


class DeviceRefusedError(DriverError):
    """The device understood the request and refused it."""


class NotInitialisedError(DeviceRefusedError):
    """The device must be initialised first."""


class BusyError(DeviceRefusedError):
    """The device is doing something else."""


class TargetRefusedError(DeviceRefusedError):
    """A joint target is outside what the robot accepts."""


class MeasurementFailedError(DriverError):
    """The instrument tried to measure and could not."""


class BeamBrokenError(MeasurementFailedError):
    """The line of sight was interrupted. Operator: clear the beam, then repeat the configuration."""


class ReflectorNotFoundError(MeasurementFailedError):
    """No reflector where it was looked for. Operator: check that it is in its nest and faces the tracker."""


class ArtefactNotSeenError(MeasurementFailedError):
    """The camera does not see the artefact. Operator: clear its view, then repeat the configuration."""


class OutOfVolumeError(MeasurementFailedError):
    """The artefact stands outside the camera's measuring volume. Operator: choose another configuration."""
