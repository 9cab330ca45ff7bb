"""What the other side may have sent."""

from truepose_drivers.errors import RemoteProtocolError


class RwsProtocolError(RemoteProtocolError):
    """The other side sent what is no message of Robot Web Services."""
