"""A connection that its own system ends where the peer is gone.

A peer whose cable was pulled says nothing, like one whose arm moves for a minute. The two systems tell them
apart: they ask each other whether they are there, whatever the programs on them do.
"""

import socket
from typing import Final

_LOST_AFTER_MS: Final = 1500  # in which the peer's system acknowledges nothing
_ASKED_EVERY_S: Final = 1  # by the system, while nothing is sent
_SETTINGS: Final = (
    ("TCP_KEEPIDLE", _ASKED_EVERY_S),
    ("TCP_KEEPINTVL", _ASKED_EVERY_S),
    ("TCP_KEEPCNT", 1),
    ("TCP_USER_TIMEOUT", _LOST_AFTER_MS),
)


def watch_peer(connection: socket.socket) -> None:
    """Have the system end a connection within two seconds of the peer's going, as far as this system can."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _SETTINGS:
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
