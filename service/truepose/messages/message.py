"""What is said to people, as a key of the catalogues and the values that it fills in.

A message is kept and handed on as it is; whatever shows it to a person makes words of it, in the language and
units of who reads (`catalogue`).
"""

from dataclasses import dataclass
from typing import TypeAlias, Union

# A text among the values is a name of the trade ("joint 2", "time") or of somebody's own ("u_mm").
Value: TypeAlias = Union[str, int, float, "Message", tuple["Value", ...]]


@dataclass(frozen=True, slots=True)
class Message:
    """A sentence, or a part of one, that can be said in every language of the catalogues."""

    key: str
    values: tuple[tuple[str, Value], ...] = ()


Text: TypeAlias = Message | str  # a str is in the words of whoever wrote it, and stays as it is


def message(key: str, /, **values: Value) -> Message:
    """Return the message of a key of the catalogue, with what it fills in."""
    return Message(key, tuple(values.items()))


def together(*texts: Text) -> Text:
    """Return several sentences as one text, in their order; empty ones are left out."""
    told = tuple(text for text in texts if text != "")
    if len(told) < 2:
        return told[0] if told else ""
    return message("sentences", sentences=told)


def is_said_in(said: Text, text: Text) -> bool:
    """Whether a message is a text, or one of those that were put `together` in it."""
    match text:
        case Message("sentences", ((_, tuple(parts)),)) if text != said:
            return any(is_said_in(said, part) for part in parts if isinstance(part, Message | str))
    return text == said


def as_sentence(text: Text) -> Text:
    """Return a text with its full stop; what other packages say, as drivers do, may come without one."""
    if isinstance(text, Message) or text.rstrip().endswith((".", "!", "?")):
        return text
    return f"{text.rstrip()}."


def key_of(text: Text) -> str:
    """Return the key of a message that stands alone; "" of several together, and of somebody's own words."""
    return text.key if isinstance(text, Message) and text.key != "sentences" else ""


def leading_key(text: Text) -> str:
    """Return the key of the first sentence; "" where it is in somebody's own words."""
    match text:
        case Message("sentences", ((_, (Message() as first, *_)),)):
            return leading_key(first)
        case Message(key):
            return key
    return ""
