"""Which numbers of a file can be a quantity at all."""

from typing import Final

# No length, angle, time or torque in any unit comes near; and its square, of which uncertainties are
# made, still is an ordinary float.
GREATEST_NUMBER: Final = 1e30


def is_plausible(number: float) -> bool:
    """Whether a number is finite and not absurdly large."""
    return -GREATEST_NUMBER <= number <= GREATEST_NUMBER
