"""Whether a session without the ballbar may move the arm: the bar may hang where an earlier session left it.

A session with the ballbar that is ended early asks nobody to take it off. Whoever confirms the next one looks
at a cell in which they expect no ballbar; so the bar is asked, where there is one that answers.
"""

from typing import Final

from truepose.domain.cell.artefacts import BallbarKit
from truepose.operation.devices import Rack
from truepose.operation.errors import MissingDeviceError
from truepose.sequencing.ballbar.measuring.attachment import Evidence
from truepose.sequencing.errors import NotNowError
from truepose_drivers.api import Ballbar, Clock
from truepose_drivers.errors import DriverError

_SAMPLES: Final = 12  # enough to see that it is off, or that it does not move as in a hand
_EVERY_S: Final = 0.05
_LEFT_ON: Final = (
    "The ballbar reads a length within its range: it may be between two balls since the last session, or on "
    "its calibrator. Take it off and lay it aside, or unplug it, then confirm."
)


async def require_ballbar_aside(rack: Rack, kit: BallbarKit | None) -> None:
    """Raise NotNowError where the cell's ballbar reads a length; one that cannot be read says nothing."""
    try:
        ballbar = rack.ballbar
    except MissingDeviceError:
        return
    was_open = ballbar.connected
    try:
        left_on = await _is_connected(ballbar, rack.clock, Evidence((kit or BallbarKit()).range_mm))
    except DriverError:
        return
    finally:
        if not was_open:
            await ballbar.close()
    if left_on:
        raise NotNowError(_LEFT_ON)


async def _is_connected(ballbar: Ballbar, clock: Clock, evidence: Evidence) -> bool:
    if not ballbar.connected:
        await ballbar.connect()
    for _ in range(_SAMPLES):
        reading = await ballbar.read()
        evidence.note(reading, reading.deviation_mm)  # nobody knows another zero than its own
        if evidence.says(reading.time_s) == "off":
            return False
        await clock.sleep(_EVERY_S)
    return evidence.says(reading.time_s) == "connected"
