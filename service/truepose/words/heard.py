"""Sentences that the service keeps in English, in the words of who reads them.

What a session was asked and why it waits is kept as a sentence: a record says what was said. `stored.json`
has those sentences with their blanks; a text that was kept is taken apart by them. What is not among them,
such as the words of a driver or of a person, stays as it is.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from truepose.domain.sentences import Sentence, Text
from truepose.words.units import Printed

_BLANK: Final = re.compile(r"\{(\w+)\}")
_END: Final = re.compile(r"(?<=[.?!])\s+|$")  # of a sentence
_SENTENCES: Final = "sentence"  # a blank that holds whole ones
_NUMBER: Final = re.compile(r"[-+]?\d+(?:\.(\d+))?")


@dataclass(frozen=True, slots=True)
class Patterns:
    """The sentences that are known, by their keys."""

    known: tuple[tuple[str, re.Pattern[str]], ...]

    @classmethod
    def of(cls, texts: Mapping[str, str]) -> "Patterns":
        """Return the patterns of English texts; those that say more without a blank come first."""
        plain = sorted(texts, key=lambda key: (-len(_BLANK.sub("", texts[key])), key))
        return cls(tuple((key, _pattern(texts[key])) for key in plain))

    def pieces(self, text: str) -> Iterator[Text]:
        """Yield the sentences of a text: what is known as such, what is not as it was kept."""
        begin, unknown = 0, 0
        ends = [match.start() for match in _END.finditer(text)]
        while begin < len(text):
            end, sentence = self._longest(text, begin, ends)
            if sentence is None:
                begin = _after(text, next(one for one in ends if one > begin))
                continue
            if unknown < begin:
                yield text[unknown:begin].rstrip()
            yield sentence
            begin = unknown = _after(text, end)
        if unknown < len(text):
            yield text[unknown:].rstrip()

    def _longest(self, text: str, begin: int, ends: list[int]) -> tuple[int, Sentence | None]:
        for end in reversed([one for one in ends if one > begin]):
            sentence = self._sentence(text[begin:end])
            if sentence is not None:
                return end, sentence
        return begin, None

    def _sentence(self, text: str) -> Sentence | None:
        for key, pattern in self.known:
            match = pattern.fullmatch(text)
            if match:
                return Sentence(
                    key, tuple((name, self._value(said)) for name, said in match.groupdict().items())
                )
        return None

    def _value(self, said: str) -> Text:
        """Return what a blank holds: a number, sentences that are known themselves, or words as they are."""
        number = _NUMBER.fullmatch(said)
        if number:
            return _printed(float(said), f"{'+' * said.startswith('+')}.{len(number[1] or '')}f")
        pieces = tuple(self.pieces(said))
        if all(isinstance(piece, str) for piece in pieces):
            return said
        return pieces[0] if len(pieces) == 1 else Sentence("sentences", (("sentences", pieces),))


def _printed(value: float, form: str) -> Printed:
    return Printed(lambda shown: shown.formatted(value, form))


def _after(text: str, end: int) -> int:
    """Return where the next sentence begins."""
    return end + len(text[end:]) - len(text[end:].lstrip())


def _pattern(text: str) -> re.Pattern[str]:
    parts = _BLANK.split(text)  # words and names of blanks, by turns
    named = [_blank(part) if n % 2 else re.escape(part) for n, part in enumerate(parts)]
    return re.compile("".join(named), re.DOTALL)


def _blank(name: str) -> str:
    return rf"(?P<{name}>.+?[.?!])" if name == _SENTENCES else rf"(?P<{name}>.+?)"
