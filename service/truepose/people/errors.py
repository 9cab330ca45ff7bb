"""Errors of asking as somebody.

PeopleError
├── SignInRefusedError       name and secret do not go together, or open nothing any more
├── TooManyGuessesError      it was guessed too often; another try in `retry_after_s`
├── FreshSignInNeededError   whoever asks has to show once more that it is them
├── NotAllowedError          the role of whoever asks is too low for it
├── SomebodyElseActsError    another person or tablet has the authority over a session
├── UnknownPersonError       nobody of that name is entered
├── AccountRefusedError      what is wished for an account cannot be
└── ActsUnwrittenError       the newest acts are not on disk yet; also a RecordRefusedError
"""

from truepose.domain.errors import RecordRefusedError, TrueposeError
from truepose.messages.message import Text, message


class PeopleError(TrueposeError):
    """Base of every error of asking as somebody."""


class SignInRefusedError(PeopleError):
    """Name and secret do not go together, or open nothing any more. The sentence says not which."""


class TooManyGuessesError(PeopleError):
    """It was guessed too often."""

    def __init__(self, retry_after_s: int) -> None:
        super().__init__(message("people.too_many", seconds=retry_after_s))
        self.retry_after_s = retry_after_s


class FreshSignInNeededError(PeopleError):
    """Whoever asks has to show once more that it is them."""

    def __init__(self) -> None:
        super().__init__(message("people.fresh"))


class NotAllowedError(PeopleError):
    """The role of whoever asks is too low for it."""


class SomebodyElseActsError(PeopleError):
    """Another person or tablet has the authority over a session."""


class UnknownPersonError(PeopleError):
    """Nobody of that name is entered."""


class AccountRefusedError(PeopleError):
    """What is wished for an account cannot be."""


class ActsUnwrittenError(PeopleError, RecordRefusedError):
    """The newest acts are not on disk yet, so that nobody can be shown all of them."""

    def __init__(self, why: Text) -> None:
        super().__init__(message("people.acts_unwritten", why=why))
