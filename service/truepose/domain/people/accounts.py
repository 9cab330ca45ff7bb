"""Who may ask for what: roles, and what a person or a program is in this service.

Four roles stand above each other: whoever measures may look as well. Two stand beside them. A device is a
program or an instrument that brings data and has them computed, and never lets an arm move. A plant collects
the records of the cell, hands down plans and models, and may do nothing else.
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
    PLANT = "plant"  # a program: collects what is on record, hands down


MACHINE: Final = "the administrator of the machine"  # who may read the database's own files
OF_PROGRAMS: Final = frozenset({Role.DEVICE, Role.PLANT})  # of no person
_LADDER: Final = (Role.VIEWER, Role.OPERATOR, Role.METROLOGIST, Role.ADMINISTRATOR)


def reaches(role: Role, least: Role) -> bool:
    """Whether `role` stands at `least` or above it; a program's role stands on no rung."""
    return role in _LADDER and _LADDER.index(role) >= _LADDER.index(least)


def lesser(one: Role, other: Role) -> Role:
    """Return what is left of one role for somebody who has the other; a program's is left to everybody."""
    of_program = next((role for role in (one, other) if role in OF_PROGRAMS), None)
    return of_program or min(one, other, key=_LADDER.index)


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
