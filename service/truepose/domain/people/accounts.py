"""Who may ask for what: roles, and what a person or a program is in this service.

Four roles stand above each other: whoever measures may look as well. A device stands beside them: a program
or an instrument that brings data and has them computed, and never lets an arm move.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from truepose.domain.people.names import tidy_name


class Role(StrEnum):
    """What somebody may do."""

    VIEWER = "viewer"  # looks, and stops what moves
    OPERATOR = "operator"  # measures
    METROLOGIST = "metrologist"  # judges and corrects
    ADMINISTRATOR = "administrator"  # says who may do what
    DEVICE = "device"  # a program: looks, plans, brings data


MACHINE: Final = "the administrator of the machine"  # who may read the database's own files
_LADDER: Final = (Role.VIEWER, Role.OPERATOR, Role.METROLOGIST, Role.ADMINISTRATOR)


def reaches(role: Role, least: Role) -> bool:
    """Whether `role` stands at `least` or above it; a device stands on no rung."""
    return role in _LADDER and _LADDER.index(role) >= _LADDER.index(least)


def lesser(one: Role, other: Role) -> Role:
    """Return what is left of one role for somebody who has the other; a device's is left to everybody."""
    if Role.DEVICE in (one, other):
        return Role.DEVICE
    return min(one, other, key=_LADDER.index)


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody who was entered; `active` ends when they are removed, the name stays taken."""

    id: int
    name: str
    role: Role
    active: bool = True


def same_person(one: str, other: str) -> bool:
    """Whether two names are one person's; capitals and blanks do not matter."""
    return tidy_name(one).casefold() == tidy_name(other).casefold()
