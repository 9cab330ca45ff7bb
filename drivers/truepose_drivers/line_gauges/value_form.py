"""Values as a gauge's display has them, and the form that all values of one gauge share.

A digit that was lost, one that came twice and a gauge that shows inches give a number of another form: of
another width, or with other digits behind the point. So a number is taken only in the form of all others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from truepose_drivers.errors import RemoteProtocolError

_FIELD_WIDTH: Final = 9
_FINEST_DECIMALS: Final = 4  # in millimetres, 0.1 um: with more of them a gauge shows inches
MOST_LESSONS: Final = 3  # values that may follow each other without agreeing
MOST_DECIMALS: Final = 6  # that fit the field

_Form: TypeAlias = tuple[int, int]  # characters behind the sign, digits behind the point


@dataclass(frozen=True, slots=True)
class Value:
    """What the gauge displays, in its own unit; `decimals` digits stand behind the point."""

    shown: float
    decimals: int
    width: int = field(default=_FIELD_WIDTH, compare=False)  # characters behind the sign, as they came

    @property
    def form(self) -> _Form:
        """Characters behind the sign, and digits behind the point."""
        return self.width, self.decimals


def read_value(sign_and_digits: str) -> Value:
    """Read a signed number as a display writes it, such as `+0000.123`."""
    whole, _, decimals = sign_and_digits[1:].partition(".")
    return Value(float(f"{sign_and_digits[0]}{whole}.{decimals}"), len(decimals), len(sign_and_digits) - 1)


def write_value(value: Value, width: int = _FIELD_WIDTH) -> str:
    """Return sign and digits in a field of `width` characters."""
    return f"{'-' if value.shown < 0.0 else '+'}{abs(value.shown):0{width}.{value.decimals}f}"


class ValueForm:
    """The form of one gauge's values, stated or learnt from values that follow each other and agree."""

    def __init__(self, decimals: int | None, error: type[RemoteProtocolError]) -> None:
        """Prepare; `decimals` stand behind the point in millimetres, learnt unless given."""
        self._stated_decimals = decimals
        self._error = error
        self._form: _Form | None = None

    @property
    def known(self) -> bool:
        """Whether it was learnt."""
        return self._form is not None

    @property
    def resolution_mm(self) -> float:
        """Of the last digit; the finest there is until the form is known."""
        return 10.0 ** -(_FINEST_DECIMALS if self._form is None else self._form[1])

    def learn(self, before: Value, after: Value) -> None:
        """Take the form of two values that follow each other, where they agree and may be millimetres."""
        if self._form is None and before.form == after.form and before.decimals in self._acceptable_decimals:
            self._form = before.form

    def require(self, value: Value) -> None:
        """See that a value has the form of all others; raises the error given."""
        if value.form != self._form:
            raise self._error(
                f"the gauge sends {value.decimals} digits behind the point, {value.width} characters in all,"
                f" where {self._expected} belong: it shows inches, or characters were lost; set it to"
                " millimetres, and for another gauge on this cable start the service again"
            )

    @property
    def _acceptable_decimals(self) -> Sequence[int]:
        if self._stated_decimals is not None:
            return (self._stated_decimals,)
        return range(_FINEST_DECIMALS + 1)

    @property
    def _expected(self) -> str:
        if self._form is not None:
            width, decimals = self._form
            return f"{decimals} and {width}"
        return " or ".join(map(str, self._acceptable_decimals))
