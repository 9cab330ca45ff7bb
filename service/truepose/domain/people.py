"""People: their names, and the roles that say who may ask for what.

Names of people: what counts as one, and whether two of them are the same. A name stands beside every
confirmation, for whoever asks later who looked at the cell. So it must be one that can be read: there is a
letter or a digit in it, and nothing that nobody sees.

Who may ask for what: roles, and what a person or a program is in this service. Four roles stand above each
other: whoever measures may look as well. Two stand beside them. A device is a program or an instrument that
brings data and has them computed, and never lets an arm move. A plant collects the records of the cell, hands
down plans and models, and may do nothing else.
"""

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import Final

from truepose.messages.message import Message, message

LONGEST_NAME: Final = 200

# Controls, format characters, fillers that look like nothing, private use, non-characters.
_NEVER = (
    r"\u0000-\u001f\u007f-\u009f\u00ad\u034f\u0600-\u0605\u061c\u06dd\u070f\u0890\u0891\u08e2\u115f\u1160"
    r"\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u2028-\u202e\u2060-\u206f\u2800\u3164\ue000-\uf8ff"
    r"\ufdd0-\ufdef\ufe00-\ufe0f\ufeff\uffa0\ufff0-\uffff"
)
# Blocks of blanks, punctuation, symbols and combining marks: a name has something else as well.
_NOT_ALONE = (
    r" -/:-@\[-`{-~\u00a0-\u00a9\u00ab-\u00b4\u00b6-\u00b9\u00bb-\u00bf\u00d7\u00f7\u02b9-\u02df\u02e5-\u036f"
    r"\u0483-\u0489\u0591-\u05c7\u0610-\u061f\u064b-\u065f\u1680\u1ab0-\u1aff\u1dc0-\u1dff\u2000-\u206f"
    r"\u20a0-\u20ff\u2190-\u2bff\u2e00-\u2e7f\u3000-\u3004\u3008-\u3020\ua670-\ua67d\ud7fc-\ud7ff"
    r"\ufe10-\ufe6f\uff00-\uff0f\uff1a-\uff20\uff3b-\uff40\uff5b-\uff65\uffe0-\uffef"
)
# For schemas: each reader of a pattern understands these ranges alike. `fault_of_name` knows more of Unicode.
NAME_PATTERN: Final = f"^[^{_NEVER}]*[^{_NEVER}{_NOT_ALONE}][^{_NEVER}]*$"

_UNSEEN: Final = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
_FILLERS: Final = frozenset("\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u2800\u3164\uffa0") | {
    chr(code) for code in range(0xFE00, 0xFE10)
}


def tidy_name(text: str) -> str:
    """Return a name as it is kept: composed characters (NFC), single blanks, none around it.

    Parameters
    ----------
    text : str
        As somebody typed it.
    """
    return re.sub(" {2,}", " ", unicodedata.normalize("NFC", text).strip())


def fault_of_name(name: str) -> Message | None:
    """Return what is wrong with a tidy name, as the end of a sentence; None where it can be read.

    Parameters
    ----------
    name : str
        As of `tidy_name`.
    """
    kinds = [unicodedata.category(sign) for sign in name]
    if len(name) > LONGEST_NAME:
        return message("name.fault.long", characters=len(name), enough=LONGEST_NAME)
    unseen = next((s for s, kind in zip(name, kinds, strict=True) if kind in _UNSEEN or s in _FILLERS), None)
    # A person named U+200B, which nobody sees, once confirmed a motion (docs/decisions/0019).
    if unseen is not None:
        return message("name.fault.unseen", character=f"U+{ord(unseen):04X}")
    # Combining marks with nothing in front of them would be drawn over whatever stands before the name.
    if any(after[0] == "M" and before[0] == "Z" for before, after in pairwise(["Z", *kinds])):
        return message("name.fault.accent")
    if not any(kind[0] == "L" or kind == "Nd" for kind in kinds):
        return message("name.fault.no_letter")
    return None


def readable_name(text: str | None) -> str | None:
    """Return a name as it is kept, None where there is none that can be read.

    Parameters
    ----------
    text : str or None
    """
    name = tidy_name(text or "")
    return None if fault_of_name(name) else name


def announced_as(name: str, people: Iterable[str]) -> str | None:
    """Return how a person was announced, None where nobody of that name was; capitals do not matter.

    Parameters
    ----------
    name : str
        As it was typed.
    people : iterable of str
        Names of the cell file.
    """
    # casefold and not lower: a sharp s and the two letters that capitals make of it are one name.
    wanted = tidy_name(name).casefold()
    return next((person for person in people if tidy_name(person).casefold() == wanted), None)


class Role(StrEnum):
    """Role of a person or program."""

    VIEWER = "viewer"  # looks, and stops what moves
    OPERATOR = "operator"  # measures
    METROLOGIST = "metrologist"  # judges and corrects
    ADMINISTRATOR = "administrator"  # says who may do what
    DEVICE = "device"  # a program: looks, plans, brings data
    PLANT = "plant"  # a program: collects what is on record, hands down


MACHINE: Final = "the administrator of the machine"  # who may read the database's own files
OF_PROGRAMS: Final = frozenset({Role.DEVICE, Role.PLANT})  # of no person
# Programs stand on no rung: none of them may ever be taken for an operator who lets an arm move.
_LADDER: Final = (Role.VIEWER, Role.OPERATOR, Role.METROLOGIST, Role.ADMINISTRATOR)


def reaches(role: Role, least: Role) -> bool:
    """Say whether a role stands at another or above it; a program's stands on no rung, and at itself alone.

    Parameters
    ----------
    role, least : Role
    """
    rungs = role in _LADDER and least in _LADDER
    return role is least or (rungs and _LADDER.index(role) > _LADDER.index(least))


def lesser(one: Role, other: Role) -> Role:
    """Return what is left of one role for somebody who has the other; a program's is left to everybody.

    Parameters
    ----------
    one, other : Role
        Symmetric for people; of two programs' roles it is `one`.
    """
    of_program = next((role for role in (one, other) if role in OF_PROGRAMS), None)
    return of_program or min(one, other, key=_LADDER.index)


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody who was entered; `active` ends when they are removed, the name stays taken."""

    id: int
    name: str
    role: Role
    # The name stays taken, so that an old confirmation is never read as somebody else's.
    active: bool = True


def same_person(one: str, other: str) -> bool:
    """Say whether two names are one person's; capitals and blanks do not matter."""
    return tidy_name(one).casefold() == tidy_name(other).casefold()
