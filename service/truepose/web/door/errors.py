"""Errors of the door.

DoorError
├── UnusableHostError    what should be allowed is no name of a host
└── UnusableProxyError   what should be a proxy is no address, or is everybody
"""

from truepose.domain.errors import TrueposeError


class DoorError(TrueposeError):
    """Base of every error of the door."""


class UnusableHostError(DoorError):
    """What should be allowed is no name of a host."""


class UnusableProxyError(DoorError):
    """What should be a proxy is no address, or is everybody."""
