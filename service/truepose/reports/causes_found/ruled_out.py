"""What was ruled out and why, joined where the same reason holds for several subjects."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from truepose.domain.diagnosis import RuledOut
from truepose.domain.sentences import Text
from truepose.reports.causes import effect_words
from truepose.reports.rounding import MISSING, millimetres, p_value
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
            effect_words(effect),
            subjects(entry.subject for entry in group),
            words.spoken(reason),
            _smallest(group),
            _at_most(group),
        )
        for (effect, reason), group in groups.items()
    )


def subjects(names: Iterable[str]) -> str:
    """Return subjects as one phrase, e.g. "joints 1, 2, 4; tool"."""
    numbered: dict[tuple[str, str], list[str]] = {}
    for name in dict.fromkeys(names):
        noun, number, rest = _split(name)
        numbered.setdefault((noun, rest), []).append(number)
    return "; ".join(filter(None, (_phrase(*words, numbers) for words, numbers in numbered.items())))


def _split(name: str) -> tuple[str, str, str]:
    """Return noun, number and what follows of e.g. `joint 3` or `joint 3, time, jump`."""
    match = re.fullmatch(r"(\w+) (\d+)((?:, .*)?)", name)
    return (match[1], match[2], match[3]) if match else (name, "", "")


def _phrase(noun: str, rest: str, all_numbers: list[str]) -> str:
    numbers = sorted(filter(None, all_numbers), key=int)
    if len(numbers) < 2:
        return " ".join([noun, *numbers]) + rest
    more = len(numbers) - _MOST_NAMED
    listed = ", ".join(numbers[:_MOST_NAMED])
    return f"{noun}s {listed}" + (f" and {more} more" if more > 0 else "") + rest


def _smallest(group: list[RuledOut]) -> str:
    return " ".join(_bounds(sorted(entry.p_value for entry in group if entry.p_value is not None)))


def _at_most(group: list[RuledOut]) -> str:
    limits = [entry.upper_limit_mm for entry in group if entry.upper_limit_mm is not None]
    return f"{millimetres(max(limits))} mm" if limits else MISSING


def _bounds(values: list[float]) -> Iterator[str]:
    if not values:
        yield MISSING
        return
    yield p_value(values[0])
    if p_value(values[-1]) != p_value(values[0]):
        yield f"to {p_value(values[-1])}"
