"""What the name of a column says: the words of several trades and languages, numbers and units."""

import re
import unicodedata
from dataclasses import dataclass
from typing import Final

from truepose.exchange.brought.guessing.quantities import (
    AXES,
    MEANS_NOTHING,
    OF_THE_FORMAT,
    QUANTITIES,
    Meaning,
)
from truepose.exchange.brought.guessing.vocabulary import (
    MEANT_BY,
    MEASURED,
    MOTOMAN,
    NAMED_JOINTS,
    NOMINAL,
    NOT_A_PLACE,
    SPREAD,
    SYMBOLS,
    UNITS,
)

_SIGN: Final = re.compile(r"[a-z]+|\d+")
_IN_BRACKETS: Final = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]")


@dataclass(frozen=True, slots=True)
class Heading:
    """What the name of a column says; words that it does not know tell columns of a kind apart."""

    meaning: Meaning
    stem: str = ""  # the name without number, axis and unit
    nominal: bool = False
    measured: bool = False


def heading(name: str) -> Heading:
    """Return what the name of a column says."""
    exact = OF_THE_FORMAT.get(name)
    if exact is not None:
        return Heading(Meaning(exact.name, 0, next(iter(exact.units), "")))
    tokens, unit = _taken_apart(name)
    nominal, measured = bool(NOMINAL & set(tokens)), bool(MEASURED & set(tokens))
    words = [token for token in tokens if token not in MEASURED] or tokens
    found = _axis(words, unit) or _orientation(words) or _numbered(words, unit) or _plain(words, unit)
    stem = " ".join(token for token in tokens if not token.isdecimal() and token not in AXES)
    return Heading(found or MEANS_NOTHING, stem, nominal, measured)


def unit_of(word: str) -> str:
    """Return the unit that a word is; "" where it is none."""
    return UNITS.get(_plain_letters(word).replace(" ", ""), "")


def series(name: str) -> tuple[str, int] | None:
    """Return the name before the one number in it, and that number: columns named alike are one thing."""
    tokens, _ = _taken_apart(name)
    numbers = [token for token in tokens if token.isdecimal()]
    if len(numbers) != 1:
        return None
    return " ".join(token for token in tokens if not token.isdecimal()), int(numbers[0])


def _taken_apart(name: str) -> tuple[list[str], str]:
    """Return the words and numbers of a name, and the unit that it says."""
    bracketed = _IN_BRACKETS.search(name)
    unit = unit_of(bracketed[1].split("/")[0]) if bracketed else ""
    bare = _IN_BRACKETS.sub(" ", name) if unit else name
    tokens = _SIGN.findall(_plain_letters(bare))
    if not unit and len(tokens) > 1 and tokens[-1] in UNITS:
        return tokens[:-1], UNITS[tokens[-1]]
    return tokens, unit


def _plain_letters(text: str) -> str:
    """Return a text in small letters without accents; Greek letters and signs by their names."""
    spelled = "".join(SYMBOLS.get(letter, letter) for letter in text)
    marked = unicodedata.normalize("NFKD", spelled.replace("\u00df", "ss"))
    joined = "".join(letter for letter in marked if not unicodedata.combining(letter))
    # "PosX" and "TcpX" are two words, "POSX" is one.
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", joined).lower()


def _axis(words: list[str], unit: str) -> Meaning | None:
    """Return a coordinate: a name with one of x, y, z in it; or how uncertain coordinates are."""
    found = [AXES.index(word) + 1 for word in words if len(word) == 1 and word in AXES]
    if not found:
        found = [AXES.index(word[-1]) + 1 for word in words if word in _AXIS_WORDS]
    others = {word for word in words if word not in AXES}
    if len(found) != 1 or others & NOT_A_PLACE:
        return None
    if others & SPREAD:
        return Meaning("uncertainty", 0, unit)
    return Meaning("position", found[0], unit)


_AXIS_WORDS: Final = frozenset(f"{word}{axis}" for word in ("pos", "p", "tcp", "t") for axis in AXES)


def _orientation(words: list[str]) -> Meaning | None:
    joined = "".join(words)
    match = re.fullmatch(r"(?:.*quat(?:ernion)?|q)([wxyz])", joined)
    return Meaning(f"q{match[1]}") if match else None


def _numbered(words: list[str], unit: str) -> Meaning | None:
    """Return what has a number behind its word: a joint, a torque, a direction."""
    joined = "".join(word for word in words if word not in NOMINAL)
    if joined in NAMED_JOINTS and unit in {"deg", "rad", "mrad"}:
        return Meaning("joint", NAMED_JOINTS[joined], unit)
    match = re.fullmatch(r"(\D+?)(\d{1,2})\D*", joined)
    if match is None:
        return None
    names = [word for word in words if not word.isdecimal()]
    kinds = [MEANT_BY[word] for word in (match[1], *names) if word in MEANT_BY]
    kind = next((one for one in ("torque", "direction", "joint") if one in kinds), None)
    return None if kind is None else Meaning(kind, int(match[2]), unit)


def _plain(words: list[str], unit: str) -> Meaning | None:
    joined = "".join(words)
    known = [MEANT_BY[word] for word in (joined, *words) if word in MEANT_BY]
    kind = next((name for name in known if not QUANTITIES[name].numbered), None)
    if kind is None:
        return None
    units = QUANTITIES[kind].units
    return Meaning(kind, 0, unit if unit in units else "")


def motoman(names: list[str]) -> dict[int, int]:
    """Return the joints, by column, of a table whose columns are called S L U R B T."""
    plain = [_taken_apart(name)[0] for name in names]
    found = {
        tokens[0]: at for at, tokens in enumerate(plain) if len(tokens) == 1 and tokens[0] in set(MOTOMAN)
    }
    return (
        {at: MOTOMAN.index(letter) + 1 for letter, at in found.items()} if len(found) == len(MOTOMAN) else {}
    )
