"""What our own server on the controller adds to open_abb: it stops a motion when nobody is heard any more.

Whoever does not ask for it notices nothing: the identity has one more field at its end, and the codes 94 to
96, which the stock server does not have, go to our server only.
"""

from typing import Final

from truepose_drivers.abb_open_abb.protocol import OUR_SERVER, Code, encode_request

SILENCE_S: Final = 0.8  # after which the controller stops the arm; it looks every 0.1 s
BEAT_S: Final = 0.2  # so often the driver is heard while the arm moves
STOPS_WITHIN_S: Final = 1.0  # silence, look and deceleration

BEAT: Final = encode_request(Code.BEAT)


def is_our_server(fields: list[str]) -> bool:
    """Whether an identity, in its fields, is that of a server that can watch."""
    return OUR_SERVER in fields[3:]
