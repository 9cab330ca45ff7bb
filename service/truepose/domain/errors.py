"""Errors of the numerics, and the one that every keeper of records shares.

TrueposeError
├── ConfigurationError        an argument does not fit the robot or the campaign
│   └── UnsuitableModelError    a model lacks what is asked of it
├── UnderdeterminedError      fewer observations than parameters
├── UnknownEffectError        no effect of that name is registered
├── InstalledCauseError       what another package brought failed while it worked
└── RecordRefusedError        what was to be kept could not be; nothing of it was

Whoever calls the numerics catches `TrueposeError`; anything else that leaves them is a fault of the program.
"""

from truepose.messages.catalogue import english
from truepose.messages.message import Text


class TrueposeError(Exception):
    """Base of every error that the service raises on purpose; its text is one sentence for the user.

    The text may be a message of the catalogues: whoever reads it has it in their language, a log in English.

    Examples
    --------
    >>> import truepose as tp
    >>> try:
    ...     tp.read_campaign("no-such-folder")
    ... except tp.TrueposeError as error:
    ...     print(error)
    no-such-folder: there is no such campaign folder.
    """

    def __init__(self, text: Text = "") -> None:
        super().__init__(text)
        self.text: Text = text

    def __str__(self) -> str:
        return english(self.text)


class ConfigurationError(TrueposeError):
    """An argument does not fit the robot or the campaign."""


class UnsuitableModelError(ConfigurationError):
    """A model lacks what is asked of it: its measured zone, or the axes that a format describes."""


class UnderdeterminedError(TrueposeError):
    """There are fewer observations than parameters."""


class UnknownEffectError(TrueposeError):
    """No effect of that name is registered."""


class InstalledCauseError(TrueposeError):
    """A cause that another package brought failed while it worked."""


class RecordRefusedError(TrueposeError):
    """What was to be kept could not be, and nothing of it was; it may be kept later.

    Raised by every storage, hence a word of the domain: a session holds the refused lines and tries again.
    """


def text_of(error: BaseException) -> Text:
    """Return what an error says, as a message where it has one; that of another package in its own words.

    Parameters
    ----------
    error : BaseException
        Of a driver too, which knows no messages.
    """
    return error.text if isinstance(error, TrueposeError) else str(error)
