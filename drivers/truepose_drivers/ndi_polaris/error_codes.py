"""What the numbers of refusals mean to the operator; go by number, tables of names disagree."""

from collections.abc import Mapping

from truepose_drivers.errors import (
    BusyError,
    ConnectionLostError,
    DeviceRefusedError,
    DriverError,
    NotInitialisedError,
)
from truepose_drivers.ndi_polaris.protocol import NdiProtocolError

_NOT_INITIALISED: Mapping[int, str] = {
    0x08: "it no longer knows the port handle",
    0x0C: "it is not tracking",
    0x0E: "the artefact is not initialised",
    0x0F: "the artefact is not enabled",
    0x10: "it is not initialised",
    0x2B: "the port handle was freed",
    0x2C: "the port handle is empty",
}
_DAMAGED: Mapping[int, str] = {
    0x02: "the command was too long",
    0x03: "the command was too short",
    0x04: "the checksum of the command was wrong",
}
_REFUSED: Mapping[int, str] = {
    0x0D: "there is no tool in the port",
    0x12: "it cannot start tracking: check its status LEDs",
    0x13: "it cannot use the definition of the artefact: check the file in option tool_file",
    0x1F: "it cannot store the definition of the artefact: switch it off and on",
    0x28: "too many tools are loaded: close the other programs that use it",
    0x2D: "it has no free port handle: close the other programs that use it",
    0x39: "another program is using it: close that one first",
    0x42: "no sensor is connected to its controller: check the cable",
}


class CommandUnknownError(DeviceRefusedError):
    """The camera does not know the command."""


def refusal(command: str, code: int) -> DriverError:
    """Return the error that a refusal means."""
    begin = f"the camera refused {command} (error {code:02X}): "
    if code in (0x01, 0x33, 0x34):
        return CommandUnknownError(f"{begin}this model does not support it")
    if code == 0x05:
        return BusyError(f"{begin}it took too long: wait, then repeat")
    if code in _NOT_INITIALISED:
        return NotInitialisedError(f"{begin}{_NOT_INITIALISED[code]}, initialise the camera")
    if code in _DAMAGED:
        return NdiProtocolError(f"{begin}{_DAMAGED[code]}; check the cable, then connect again")
    return DeviceRefusedError(f"{begin}{_REFUSED.get(code, 'see its manual for this number')}")


def started_again() -> ConnectionLostError:
    """Return the error of a camera that was switched off and on."""
    return ConnectionLostError("the camera was started again (RESET): connect again, then initialise it")
