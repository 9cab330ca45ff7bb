"""What our own server on the controller adds to MAPPDK: it stops a motion when nobody is heard any more.

Whoever does not ask for it notices nothing: the stock server has none of these requests, and ours does all
that the stock one does.
"""

from typing import Final

from truepose_drivers.fanuc_mappdk.protocol import Command, encode_request

SILENCE_S: Final = 0.8  # after which the controller stops the arm; it looks every 0.05 s
BEAT_S: Final = 0.2  # so often the driver is heard while the arm moves
STOPS_WITHIN_S: Final = 1.0  # silence, look and deceleration

BEAT: Final = encode_request(Command.BEAT)
