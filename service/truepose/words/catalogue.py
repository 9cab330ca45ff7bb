"""Catalogues: a sentence and its values in, words of one language out."""

import json
import re
import string
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Final

from truepose.domain.sentences import Sentence, Text, Value
from truepose.words.heard import Patterns
from truepose.words.units import KEPT, Printed, Units, blank

_FOLDER: Final = Path(__file__).parent
ENGLISH: Final = "en"  # the language of documents, records and the API
LANGUAGES: Final = tuple(sorted(path.parent.name for path in _FOLDER.glob("*/names.json")))
TABLET: Final = "tablet"  # its pages fill in their texts themselves
STORED: Final = "stored"  # sentences that the service keeps in English
TRACKER_TABLET: Final = "tracker_tablet"  # what those of tracker sessions say besides
_NAMES: Final = "names"
_APART: Final = (TABLET, TRACKER_TABLET, _NAMES)
_OPEN: Final = "open"  # without its full stop
_CAUSE: Final = "cause"  # the name of an effect
_RAW: Final = "raw"  # a name as documents have it


class Catalogue:
    """What is said in one language, with quantities in the units of who reads it."""

    def __init__(self, language: str, units: Units = KEPT) -> None:
        self.language = language
        self.units = units
        self._formatter = _Formatter(self)

    @property
    def tag(self) -> str:
        """The language, and the units that are not those kept: a language tag (RFC 5646, 2.2.7)."""
        return "-".join((self.language, *(("x", *self.units.tokens) if self.units.tokens else ())))

    @property
    def between(self) -> str:
        """What stands between the names of a list."""
        return self._texts["list.commas"]

    @property
    def stop(self) -> str:
        """What ends a sentence."""
        return self._texts["list.stop"]

    @property
    def units_named(self) -> str:
        """The units of lengths, angles and temperatures."""
        return self.listed([self.units.conversion(unit).symbol for unit in ("mm", "deg", "°C")], "commas")

    @cached_property
    def _texts(self) -> dict[str, str]:
        files = (path for path in (_FOLDER / self.language).glob("*.json") if path.stem not in _APART)
        texts = {key: text for path in files for key, text in _read(path).items()}
        return {key: self.units.text(text) for key, text in texts.items()} if self.units.tokens else texts

    @cached_property
    def _names(self) -> "Names":
        return Names(_read(texts_file(self.language, _NAMES)), self.between)

    def say(self, key: str, **values: Value) -> str:
        """Return the text of a key, filled in."""
        return self.spoken(Sentence(key, tuple(values.items())))

    def spoken(self, text: Text) -> str:
        """Return a text in this language; what is in somebody's own words stays as it is.

        So does the key of what another version has stored and this one does not know.
        """
        if isinstance(text, str):
            return text
        return self._formatter.vformat(self._texts.get(text.key, text.key), (), dict(text.values))

    def heard(self, text: str) -> list[tuple[str, str]]:
        """Return the sentences of a text that the service keeps in English, each with its language."""
        if self.tag == ENGLISH:
            return [(text, ENGLISH)] if text else []
        pieces = _patterns().pieces(text)
        return [
            (piece, ENGLISH) if isinstance(piece, str) else (self.spoken(piece), self.language)
            for piece in pieces
        ]

    def name(self, name: str, form: str = "") -> str:
        """Return what a place, a variable, a shape or another name of documents is called here."""
        return self._names.called(name, form)

    def effect(self, effect: str) -> str:
        """Return what an effect or a cause is called; one that a package brings, by its name."""
        return self.name(effect if self._names.knows(effect) else effect.replace("_", " "))

    def listed(self, values: Sequence[Value], joint: str) -> str:
        """Return values as one phrase, as `list.<joint>` of the catalogue joins them."""
        parts = [self._part(value) for value in values]
        between, _, last = self._texts[f"list.{joint}"].partition("|")
        return (last or between).join(filter(None, (between.join(parts[:-1]), *parts[-1:])))

    def _part(self, value: Value) -> str:
        return self._formatter.format_field(value, "")


class Names:
    """Names of documents in the words of a language: whole names, or patterns such as `joint {n}`."""

    def __init__(self, table: Mapping[str, str | Mapping[str, str]], between: str = ", ") -> None:
        self._between = between
        self._plain = {name: _formed(words) for name, words in table.items() if "{" not in name}
        self._patterns = [(_pattern(name), _formed(words)) for name, words in table.items() if "{" in name]

    def knows(self, name: str) -> bool:
        """Whether there is a word for it."""
        return self._found(name) is not None

    def called(self, name: str, form: str = "") -> str:
        """Return the word for a name, or for each of several after commas; the name where there is none."""
        found = self._found(name)
        if found is not None:
            return found(form)
        parts = [self._found(part) for part in name.split(", ")]
        return self._between.join(part(form) for part in parts if part) if all(parts) else name

    def _found(self, name: str) -> Callable[[str], str] | None:
        if name in self._plain:
            return self._plain[name]
        for pattern, words in self._patterns:
            match = pattern.fullmatch(name)
            if match:
                return lambda form: words(form).format(**match.groupdict())
        return None


def _formed(words: str | Mapping[str, str]) -> Callable[[str], str]:
    """Return what gives a form of a word, its plain one where it has no other."""
    forms = {"": words} if isinstance(words, str) else words
    return lambda form: forms.get(form, forms[""])


def _pattern(name: str) -> re.Pattern[str]:
    escaped = re.escape(name).replace(r"\{", "{").replace(r"\}", "}")
    numbers = escaped.replace("{numbers}", r"(?P<numbers>\d+(?:, \d+)+)")
    return re.compile(re.sub(r"\{(\w+)\}", r"(?P<\1>\\w+)", numbers))


class _Formatter(string.Formatter):
    """Fills in a text: numbers as Python formats them, names and sentences in the catalogue's words."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue

    def format_field(self, value: Any, format_spec: str) -> str:
        form, unit, gap = blank(format_spec)
        if isinstance(value, Printed) or not isinstance(value, (str, Sentence, tuple)):
            return self._catalogue.units.filled(value, form, unit, gap)
        words = self._catalogue.listed(value, form) if isinstance(value, tuple) else self._word(value, form)
        return words if gap is None else f"{words}{gap}{unit}"

    def _word(self, value: Text, spec: str) -> str:
        if isinstance(value, Sentence):
            words = self._catalogue.spoken(value)
        elif spec == _RAW:
            words = value
        elif spec == _CAUSE:
            words = self._catalogue.effect(value)
        else:
            words = self._catalogue.name(value, spec.lower())
        if spec == _OPEN:
            return words.removesuffix(".").removesuffix("。")
        return words[:1].upper() + words[1:] if spec[:1].isupper() else words


@cache
def catalogue(tag: str) -> Catalogue:
    """Return the catalogue of one of `LANGUAGES`, or of a tag that says in which units it is read."""
    language, _, units = tag.partition("-x-")
    return Catalogue(language, Units.of(units.split("-")))


@cache
def _patterns() -> Patterns:
    return Patterns.of(_read(texts_file(ENGLISH, STORED)))


IN_ENGLISH: Final = catalogue(ENGLISH)


def english(text: Text) -> str:
    """Return a text as documents hold it."""
    return IN_ENGLISH.spoken(text)


def texts_file(language: str, name: str) -> Path:
    """Return where texts of a language are, for pages that fill them in themselves."""
    return _FOLDER / language / f"{name}.json"


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
