"""Sentences: what numerics say to people, as a key of the catalogue and the values that it fills in.

No words stand here: they are in `truepose.words`, one folder a language.
"""

from dataclasses import dataclass
from typing import TypeAlias, Union

# A text among the values is a name of the trade ("joint 2", "time") or of somebody's own ("u_mm").
Value: TypeAlias = Union[str, int, float, "Sentence", tuple["Value", ...]]


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence, or a part of one, that can be said in every language of the catalogue."""

    key: str
    values: tuple[tuple[str, Value], ...] = ()


Text: TypeAlias = Sentence | str  # a str is in the words of whoever wrote it, and stays as it is


def said(key: str, **values: Value) -> Sentence:
    """Return the sentence of a key of the catalogue, with what it fills in."""
    return Sentence(key, tuple(values.items()))


def together(*texts: Text) -> Text:
    """Return several sentences as one text, in their order; empty ones are left out."""
    told = tuple(text for text in texts if text != "")
    if len(told) < 2:
        return told[0] if told else ""
    return said("sentences", sentences=told)


def leading_key(text: Text) -> str:
    """Return the key of the first sentence; "" where it is in somebody's own words."""
    match text:
        case Sentence("sentences", ((_, (Sentence() as first, *_)),)):
            return leading_key(first)
        case Sentence(key):
            return key
    return ""
