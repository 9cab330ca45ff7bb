"""Errors of sequencing; the operator reads their text.

SequencingError
├── NotNowError             the session is in a state in which this cannot be asked
├── WatchingTabletError     another tablet acts; the one that asked only watches
├── PersonMissingError      a confirmation needs the name of a person
│   └── PersonUnreadableError   what was given as a name cannot be read
├── PersonUnknownError      the cell announces people, and this is none of them
├── ReasonMissingError      a skip needs its reason, and so does a word that no signal bears out
├── PlanRefusedError        the plan does not fit the cell; found before anything moves
├── MotionForbiddenError    an interlock forbids a motion
│   └── ForeignRobotError   another robot answers than the one that is expected
├── ReadingRejectedError    an instrument answered, and the answer cannot be right
├── ForeignInstrumentError  another instrument answers; a person accepts it, or puts the right one back
└── AttentionNeededError    a person has to look at something before the session goes on
"""

from truepose.domain.errors import TrueposeError
from truepose.domain.measurement.identities import IdentityTaken


class SequencingError(TrueposeError):
    """Base of every error of a session."""


class NotNowError(SequencingError):
    """The session is in a state in which this cannot be asked."""


class WatchingTabletError(SequencingError):
    """Another tablet acts; the one that asked only watches."""


class PersonMissingError(SequencingError):
    """A confirmation needs the name of a person."""


class PersonUnreadableError(PersonMissingError):
    """What was given as a name cannot be read."""


class PersonUnknownError(SequencingError):
    """The cell announces people, and this is none of them."""


class ReasonMissingError(SequencingError):
    """A skip needs its reason, and so does a word that no signal bears out."""


class PlanRefusedError(SequencingError):
    """The plan does not fit the cell."""


class MotionForbiddenError(SequencingError):
    """An interlock forbids a motion."""


class ForeignRobotError(MotionForbiddenError):
    """Another robot answers than the one that is expected."""


class ForeignInstrumentError(SequencingError):
    """Another instrument answers; a person accepts it, or puts the right one back."""

    def __init__(self, found: IdentityTaken, sentence: str) -> None:
        super().__init__(sentence)
        self.found = found


class ReadingRejectedError(SequencingError):
    """An instrument answered, and the answer cannot be right."""


class AttentionNeededError(SequencingError):
    """A person has to look at something before the session goes on."""
