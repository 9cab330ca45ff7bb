"""Robot Web Services beside open_abb: state before every motion, joints to all digits, the event log."""

from truepose_drivers import options as option
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.conversation import RwsSession
from truepose_drivers.abb_rws.http import Login
from truepose_drivers.abb_rws.motion import read_joints, read_panel
from truepose_drivers.abb_rws.protocol import FULL_PERCENT, Execution
from truepose_drivers.api import Clock, FullRobot, JointReading, Options
from truepose_drivers.arm_motion import AccompaniedRobot
from truepose_drivers.errors import NotInitialisedError
from truepose_drivers.transports.link import OnePortDevice, introduction
from truepose_drivers.transports.tcp import tcp_link

_LOWEST_PERCENT = 1.0  # at 0 nothing moves, and no motion has a duration

LOGIN_OPTIONS = {
    "user": f'user of the controller\'s web services, default "{protocol.USER}"',
    "password": "password of that user, default: the factory password",
}


class RwsCompanion(OnePortDevice):
    """A session that asks and moves nothing."""

    def __init__(self, session: RwsSession, clock: Clock) -> None:
        super().__init__(session)
        self._session = session
        self._clock = clock
        self._speed_percent = FULL_PERCENT  # as stated last

    async def connect(self) -> None:
        """Open the link and log in; raises ConnectFailedError, DeviceRefusedError."""
        await self._session.log_in()
        async with introduction(self._session):
            await self._note_speed()

    async def close(self) -> None:
        """End the session, then close the link; never raises."""
        await self._session.leave()

    async def require_ready(self) -> None:
        """Raise NotInitialisedError where motors, program or speed override are in the way."""
        now = await read_panel(self._session)
        self._speed_percent = now.speed_percent
        if now.halt is not None:
            raise NotInitialisedError(f"the robot cannot move: {now.halt}; then confirm")
        if now.execution is Execution.STOPPED:
            raise NotInitialisedError(
                "the robot cannot move: its program is stopped; start it on the pendant, then confirm"
            )

    @property
    def speed_share(self) -> float:
        """Of the limits, as the speed override leaves it, by what was stated last."""
        return max(self._speed_percent, _LOWEST_PERCENT) / FULL_PERCENT

    async def read_joints(self) -> JointReading:
        """Ask where the joints are, and how fast the arm may be; also while it moves."""
        # Whoever cuts the next motion to a length asks for the joints just before.
        await self._note_speed()
        return await read_joints(self._session, self._clock)

    async def _note_speed(self) -> None:
        self._speed_percent = await self._session.get(protocol.SPEED_RATIO, protocol.speed_percent)

    async def last_words(self) -> str:
        """Return the newest entry of the event log."""
        return await self._session.get(f"{protocol.EVENT_LOG}?lang=en", protocol.last_event)


def login_of(options: Options) -> Login:
    """Return who logs in, by the options `user` and `password`; raises ConfigurationError."""
    user, password = option.text(options, "user"), option.text(options, "password")
    return Login(user or protocol.USER, password or protocol.PASSWORD)


def watched_by_rws(robot: FullRobot, options: Options, clock: Clock) -> FullRobot:
    """Return a robot as its options have it: watched by web services where they say at which port."""
    if "rws_port" not in options:
        return robot
    session = RwsSession(tcp_link(options, port="rws_port"), login_of(options))
    return AccompaniedRobot(robot, RwsCompanion(session, clock))
