"""What was ruled out and why, joined where the same reason holds for several subjects."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from truepose.domain.results.diagnosis import RuledOut
from truepose.domain.sentences import Text
from truepose.reports.wording.rounding import MISSING, millimetres, p_value
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MOST_NAMED = 12  # subjects of one reason; a hundred nests would fill the page


@dataclass(frozen=True, slots=True)
class RuledOutRow:
    """Causes of one effect that share a reason."""

    effect: str
    subjects: str
    reason: str
    p_value: str  # the smallest of them
    at_most: str  # how large any of them could still be


def ruled_out_rows(entries: Iterable[RuledOut], words: Catalogue = IN_ENGLISH) -> tuple[RuledOutRow, ...]:
    """Return a row for each effect and reason, in the order of the first of each."""
    groups: dict[tuple[str, Text], list[RuledOut]] = {}
    for entry in entries:
        groups.setdefault((entry.effect, entry.reason), []).append(entry)
    return tuple(
        RuledOutRow(
            words.effect(effect),
            subjects((entry.subject for entry in group), words),
            words.spoken(reason),
            _smallest(group, words),
            _at_most(group, words),
        )
        for (effect, reason), group in groups.items()
    )


def subjects(names: Iterable[str], words: Catalogue = IN_ENGLISH) -> str:
    """Return subjects as one phrase, e.g. "joints 1, 2, 4; tool"."""
    numbered: dict[tuple[str, str], list[str]] = {}
    for name in dict.fromkeys(names):
        noun, number, rest = _split(name)
        numbered.setdefault((noun, rest), []).append(number)
    phrases = (_phrase(*of, numbers, words) for of, numbers in numbered.items())
    return words.listed([*filter(None, phrases)], "semicolons")


def _split(name: str) -> tuple[str, str, str]:
    """Return noun, number and what follows of e.g. `joint 3` or `joint 3, time, jump`."""
    match = re.fullmatch(r"(\w+) (\d+)((?:, .*)?)", name)
    return (match[1], match[2], match[3]) if match else (name, "", "")


def _phrase(noun: str, rest: str, all_numbers: list[str], words: Catalogue) -> str:
    numbers = sorted(filter(None, all_numbers), key=int)
    if len(numbers) < 2:
        return words.name(" ".join([noun, *numbers]) + rest)
    more = len(numbers) - _MOST_NAMED
    listed = words.name(f"{noun}s {', '.join(numbers[:_MOST_NAMED])}")
    further = words.say("ruled_out.more", number=more) if more > 0 else ""
    return listed + further + "".join(f"{words.between}{words.name(part)}" for part in rest.split(", ")[1:])


def _smallest(group: list[RuledOut], words: Catalogue) -> str:
    return _bounds(sorted(entry.p_value for entry in group if entry.p_value is not None), words)


def _at_most(group: list[RuledOut], words: Catalogue) -> str:
    limits = [entry.upper_limit_mm for entry in group if entry.upper_limit_mm is not None]
    return words.units.quantity(millimetres(max(limits)), "mm") if limits else MISSING


def _bounds(values: list[float], words: Catalogue) -> str:
    if not values:
        return MISSING
    low, high = p_value(values[0]), p_value(values[-1])
    return low if low == high else words.say("range", low=low, high=high)
