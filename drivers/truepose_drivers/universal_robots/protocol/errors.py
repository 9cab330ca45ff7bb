"""What is no message of a Universal Robots controller."""

from truepose_drivers.errors import RemoteProtocolError


class UrProtocolError(RemoteProtocolError):
    """Bytes that are no message of this protocol, or not the one that was due."""
