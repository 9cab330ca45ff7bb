"""Reads where the joints are from a controller's stream: only what is newer than what was read before."""

import asyncio
import contextlib
import math
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.abb_egm.protocol import EGM_PORT, Motors, Rapid, RobotFrame, decode_robot
from truepose_drivers.api import Clock, FullRobot, JointReading, Options
from truepose_drivers.arm_motion import AccompaniedRobot
from truepose_drivers.errors import NoReplyError, NotInitialisedError
from truepose_drivers.transports.conversation import Turns
from truepose_drivers.transports.link import OnePortDevice, Source, drain, introduction
from truepose_drivers.transports.udp import UdpPort

EGM_OPTION: Final = (
    f"UDP port that receives joint angles by EGM, often {EGM_PORT}; without it they are polled"
)
_FRESH_WITHIN_S: Final = 0.5  # wall time; a controller sends every 4 ms, or a few multiples of it
# Doubles, of a standing arm that its servos hold.
_STANDING_RAD: Final = 1e-6


class EgmReader(OnePortDevice):
    """The stream of one controller at a port of ours."""

    def __init__(self, source: Source, clock: Clock) -> None:
        self._source = source
        super().__init__(self._source)
        self._clock = clock
        self._turns = Turns(source, harmless=(NotInitialisedError,))
        self._last: RobotFrame | None = None

    async def connect(self) -> None:
        """Listen, and see that a controller sends; raises ConnectFailedError."""
        self._last = None
        await self._source.open()
        async with introduction(self._source):
            await self.next_frame()

    async def next_frame(self) -> RobotFrame:
        """Return the first frame that arrives from now on and is newer than all before.

        Frames that come again, late or with a clock that stands are passed over. Raises NoReplyError where no
        other comes, EgmProtocolError for what is no frame; either closes the port.
        """
        async with self._turns.turn():
            # The system keeps what arrives while nobody reads: those frames are older than the question.
            await drain(self._source)
            with contextlib.suppress(TimeoutError):
                # Frames that are not newer may come for ever: the time-out of a single receive would never
                # end that.
                async with asyncio.timeout(_FRESH_WITHIN_S):
                    return await self._newer()
            raise NoReplyError(
                f"no new data arrives at {self._source.address}: check the network, the computer's address at"
                " the controller's UDPUC device, and that TruePoseEgm.mod runs, then connect again"
            )

    async def _newer(self) -> RobotFrame:
        while True:
            data = await self._source.receive(_FRESH_WITHIN_S)
            if data is None:
                continue
            frame = decode_robot(data)
            if self._last is None or frame.follows(self._last):
                self._last = frame
                return frame

    async def read_joints(self) -> JointReading:
        """Return where the joints are now."""
        frame = await self.next_frame()
        return JointReading(
            joints_rad=tuple(map(math.radians, frame.joints_deg)),
            resolution_rad=_STANDING_RAD,
            time_s=await self._clock.now_s(),
        )

    @property
    def speed_share(self) -> None:
        """A stream tells no speed override."""
        return None

    async def last_words(self) -> str:
        """Return nothing: a stream has no words."""
        return ""

    async def require_ready(self) -> None:
        """Raise NotInitialisedError where the arm cannot move, by what the controller states now."""
        frame = await self.next_frame()
        if frame.motors is Motors.OFF:
            raise NotInitialisedError(
                "the robot cannot move: its motors are off; check the cell, switch them on, then confirm"
            )
        if frame.rapid is Rapid.STOPPED:
            raise NotInitialisedError(
                "the robot cannot move: its program is stopped; start it on the pendant, then confirm"
            )


def read_by_egm(robot: FullRobot, options: Options, clock: Clock) -> FullRobot:
    """Return a robot as its options have it: read by EGM where they say at which port."""
    if "egm_port" not in options:
        return robot
    port = UdpPort(option.host(options), option.port(options, name="egm_port"))
    return AccompaniedRobot(robot, EgmReader(port, clock))
