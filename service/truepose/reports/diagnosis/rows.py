"""What a model describes without a name, and what was ruled out and why, in sentences and rows."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from truepose.domain.diagnosis import Described, EffectSize, Remaining, RuledOut
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text
from truepose.reports.cause_words import worth_words
from truepose.reports.rounding import MISSING, millimetres, p_value
from truepose.reports.tables import Remarked, Table, heads_of

_SAID = 3  # in the sentence
_LISTED = 8  # in the table


@dataclass(frozen=True, slots=True)
class DescribedRow:
    """One place and variable; lengths are text in mm."""

    place: str
    own: str  # missed without it, all other parameters fitted again
    worth: str


def described_sentence(remaining: Remaining, words: Catalogue = IN_ENGLISH) -> str:
    """Return what is described without a name, and how far that helps on unseen points."""
    listed, gain = tuple(_listed(remaining.described, words)), remaining.described_gain
    if gain is None:
        return words.say("described", places=listed)
    difference = millimetres(gain.rms_before_mm - gain.rms_after_mm)
    return words.say("described.gain", places=listed, gain=difference)


def _listed(described: tuple[Described, ...], words: Catalogue) -> Iterator[str]:
    for one in described[:_SAID]:
        yield f"{described_place(one, words)} ({words.units.quantity(own_text(one.worth), 'mm')})"
    if len(described) > _SAID:
        yield words.say("described.smaller", number=len(described) - _SAID)


def described_rows(
    described: tuple[Described, ...], words: Catalogue = IN_ENGLISH
) -> tuple[DescribedRow, ...]:
    """Return the largest ones for a table."""
    return tuple(
        DescribedRow(described_place(one, words), own_text(one.worth), worth_words(one.worth, words))
        for one in described[:_LISTED]
    )


def described_place(described: Described, words: Catalogue = IN_ENGLISH) -> str:
    """Return e.g. "joint 2 over angle of joint 1"; what depends on nothing is its place alone."""
    if described.over == "constant":
        return words.name(described.where)
    return words.say("described.place", where=described.where, over=described.over)


def own_text(worth: EffectSize) -> str:
    """Return what would be missed without it, all other parameters fitted again; without its unit."""
    return MISSING if worth.own_mm is None else millimetres(worth.own_mm)


_MOST_NAMED = 12  # subjects of one reason; a hundred nests would fill the page


def ruled_out_table(entries: Iterable[RuledOut], words: Catalogue = IN_ENGLISH, *, tried: bool) -> Table:
    """Return a row for each effect and reason, in the order of the first of each.

    Of those that were tried it has the smallest p value, and how large any of them could still be.
    """
    groups: dict[tuple[str, Text], list[RuledOut]] = {}
    for entry in entries:
        groups.setdefault((entry.effect, entry.reason), []).append(entry)
    rows = [
        (
            Remarked(words.effect(effect), subjects((entry.subject for entry in group), words)),
            words.spoken(reason),
            *((_smallest(group, words), _at_most(group, words)) if tried else ()),
        )
        for (effect, reason), group in groups.items()
    ]
    keys = ("table.why_not", "p", "table.at_most") if tried else ("table.why_unseen",)
    return Table(heads_of(words, "table.cause", *keys), rows, names=2)


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
