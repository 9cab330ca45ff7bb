"""Catalogues: a sentence and its values in, words of one language out."""

import re
import string
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property
from typing import Any, Final

from truepose.messages.message import Message, Text, Value
from truepose.messages.translations import languages, translations
from truepose.messages.units import KEPT, KNOWN, ConvertibleNumber, Format, Units, constant

ENGLISH: Final = "en"  # the language of documents, records and the API
LANGUAGES: Final = languages()
TABLET: Final = "tablet"  # its pages fill in their texts themselves
TRACKER_TABLET: Final = "tracker_tablet"  # what those of tracker sessions say besides
_NAMES: Final = "names"
# One is loaded where those before it lack a key: numerics and commands are content with the first.
_DOMAINS: Final = ("findings", "reports", "errors", "sessions", "pages", "commands")
_OPEN: Final = "open"  # without its full stop
_CAUSE: Final = "cause"  # the name of an effect
_RAW: Final = "raw"  # a name as documents have it


class Catalogue:
    """What is said in one language, with quantities in the units of who reads it."""

    def __init__(self, language: str, units: Units = KEPT) -> None:
        self.language = language
        # English is asked for nothing: most commands say one sentence, and load no catalogue for its numbers.
        self.units = units if language == ENGLISH else replace(units, decimal=self._text("list.decimal"))
        self._formatter = _Formatter(self)

    @property
    def tag(self) -> str:
        """The language, and the units that are not those kept: a language tag (RFC 5646, 2.2.7)."""
        return "-".join((self.language, *(("x", *self.units.tokens) if self.units.tokens else ())))

    @property
    def between(self) -> str:
        """What stands between the names of a list."""
        return self._text("list.commas")

    @property
    def stop(self) -> str:
        """What ends a sentence."""
        return self._text("list.stop")

    @property
    def units_named(self) -> str:
        """The units of lengths, angles and temperatures."""
        return self.listed([self.units.conversion(unit).symbol for unit in ("mm", "deg", "°C")], "commas")

    @cached_property
    def _names(self) -> "Names":
        return Names(translations(self.language, _NAMES).by_context(), self.between)

    def say(self, key: str, **values: Value) -> str:
        """Return the text of a key, filled in."""
        return self._filled(key, values)

    def spoken(self, text: Text) -> str:
        """Return a text in this language; what is in somebody's own words stays as it is.

        Of what another version has stored, and this one does not know or has other values for, it is the key.
        """
        if isinstance(text, str):
            return text
        try:
            return self._filled(text.key, dict(text.values))
        except KeyError:  # a blank for which nothing was stored
            return text.key

    def _filled(self, key: str, values: Mapping[str, Value]) -> str:
        return self._formatter.vformat(self._text(key, values.get("n")) or key, (), values)

    def name(self, name: str, form: str = "") -> str:
        """Return what a place, a variable, a shape or another name of documents is called here."""
        return self._names.called(name, form)

    def effect(self, effect: str) -> str:
        """Return what an effect or a cause is called; one that a package brings, by its name."""
        return self.name(effect if self._names.knows(effect) else effect.replace("_", " "))

    def listed(self, values: Sequence[Value], joint: str) -> str:
        """Return values as one phrase, as `list.<joint>` of the catalogue joins them."""
        parts = [self._part(value) for value in values]
        between, _, last = self._text(f"list.{joint}").partition("|")
        return (last or between).join(filter(None, (between.join(parts[:-1]), *parts[-1:])))

    def _text(self, key: str, n: object = None) -> str:
        of_domains = (translations(self.language, domain).text(key, n) for domain in _DOMAINS)
        return next(filter(None, of_domains), "")

    def _part(self, value: Value) -> str:
        return self._formatter.format_field(value, "")


class Names:
    """Names of documents in the words of a language: whole names, or patterns such as `joint {n}`."""

    def __init__(self, table: Mapping[str, Mapping[str, str]], between: str = ", ") -> None:
        self._between = between
        self._plain = {name: _formed(forms) for name, forms in table.items() if "{" not in name}
        self._patterns = [(_pattern(name), _formed(forms)) for name, forms in table.items() if "{" in name]

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


def _formed(forms: Mapping[str, str]) -> Callable[[str], str]:
    """Return what gives a form of a word, its plain one where it has no other."""
    return lambda form: forms.get(form, forms[""])


def _pattern(name: str) -> re.Pattern[str]:
    escaped = re.escape(name).replace(r"\{", "{").replace(r"\}", "}")
    numbers = escaped.replace("{numbers}", r"(?P<numbers>\d+(?:, \d+)+)")
    return re.compile(re.sub(r"\{(\w+)\}", r"(?P<\1>\\w+)", numbers))


class _Formatter(string.Formatter):
    """Fills in a text: numbers as Python formats them, names and sentences in the catalogue's words."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue

    def get_field(self, field_name: str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:
        """Return the value of a blank; a number stands for itself, and a unit for the word for it."""
        if field_name in KNOWN:
            return ConvertibleNumber(
                lambda _: self._catalogue.units.conversion(field_name).symbol
            ), field_name
        if field_name[:1].isdigit():
            return constant(field_name), field_name
        return super().get_field(field_name, args, kwargs)

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return what a blank is filled in with; a word in the place of a number has the kept unit."""
        how, units = Format.of(format_spec), self._catalogue.units
        if isinstance(value, tuple):
            words, symbol = self._catalogue.listed(value, how.form), how.unit
        elif isinstance(value, (str, Message)) and not isinstance(value, ConvertibleNumber):
            words, symbol = self._word(value, how.form), how.unit
        else:
            words, symbol = units.formatted(value, how.form, how.unit), units.conversion(how.unit).symbol
        return f"{words} {symbol}" if how.is_named else words

    def _word(self, value: Text, spec: str) -> str:
        if isinstance(value, Message):
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


IN_ENGLISH: Final = catalogue(ENGLISH)


def english(text: Text) -> str:
    """Return a text as documents hold it."""
    return IN_ENGLISH.spoken(text)
