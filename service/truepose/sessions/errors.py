"""Errors of sessions and of the devices that they use; the operator reads their text.

SessionError
├── NotNowError             the session is in a state in which this cannot be asked
├── WatchingTabletError     another tablet acts; the one that asked only watches
├── PersonMissingError      a confirmation needs the name of a person
│   └── PersonUnreadableError   what was given as a name cannot be read
├── PersonUnknownError      the cell announces people, and this is none of them
├── ReasonMissingError      a skip needs its reason, and so does a word that no signal bears out
├── PlanRefusedError        the plan does not fit the cell; found before anything moves
├── MotionForbiddenError    an interlock forbids a motion
│   ├── WayNotClearError    nobody planned the way, and something would touch on it
│   └── ForeignRobotError   another robot answers than the one that is expected
├── ReadingRejectedError    an instrument answered, and the answer cannot be right
├── ForeignInstrumentError  another instrument answers; a person accepts it, or puts the right one back
├── AttentionNeededError    a person has to look at something before the session goes on
├── UnknownDeviceError      the cell has no device of that name
├── MissingDeviceError      a session needs a kind of device that the cell file does not list
├── DeviceInUseError        a session holds the device
├── CellChangedError        the cell file says something else than the service was started with
├── NoBallbarError          the cell file does not describe a ballbar
├── FaultRefusedError       a simulated cell cannot have that go wrong
├── RealCellError           only a simulated cell can be asked that
└── CertificateError        a certificate does not hold, and nobody says why that may be passed over
"""

from truepose.domain.errors import TrueposeError
from truepose.domain.session import IdentityTaken
from truepose.messages.message import Message


class SessionError(TrueposeError):
    """Base of every error of a session, and of operating its cell."""


class NotNowError(SessionError):
    """The session is in a state in which this cannot be asked."""


class WatchingTabletError(SessionError):
    """Another tablet acts; the one that asked only watches."""


class PersonMissingError(SessionError):
    """A confirmation needs the name of a person."""


class PersonUnreadableError(PersonMissingError):
    """What was given as a name cannot be read."""


class PersonUnknownError(SessionError):
    """The cell announces people, and this is none of them."""


class ReasonMissingError(SessionError):
    """A skip needs its reason, and so does a word that no signal bears out."""


class PlanRefusedError(SessionError):
    """The plan does not fit the cell."""


class MotionForbiddenError(SessionError):
    """An interlock forbids a motion."""


class WayNotClearError(MotionForbiddenError):
    """Nobody planned the way, and something would touch on it."""


class ForeignRobotError(MotionForbiddenError):
    """Another robot answers than the one that is expected."""


class ForeignInstrumentError(SessionError):
    """Another instrument answers; a person accepts it, or puts the right one back."""

    def __init__(self, found: IdentityTaken, sentence: Message) -> None:
        super().__init__(sentence)
        self.found = found


class ReadingRejectedError(SessionError):
    """An instrument answered, and the answer cannot be right."""


class AttentionNeededError(SessionError):
    """A person has to look at something before the session goes on."""


class UnknownDeviceError(SessionError):
    """The cell has no device of that name."""


class MissingDeviceError(SessionError):
    """A session needs a kind of device that the cell file does not list."""


class DeviceInUseError(SessionError):
    """A session holds the device."""


class CellChangedError(SessionError):
    """The cell file says something else than the service was started with."""


class NoBallbarError(SessionError):
    """The cell file does not describe a ballbar."""


class FaultRefusedError(SessionError):
    """A simulated cell cannot have that go wrong."""


class RealCellError(SessionError):
    """Only a simulated cell can be asked that."""


class CertificateError(SessionError):
    """A certificate does not hold, and nobody says why that may be passed over."""
