"""Translations of one domain into one language, as gettext keeps them.

Translators write `.po` files; the service reads the `.mo` files beside them, which the build makes. In a
checkout a `.po` that was changed since is compiled when it is read.
"""

import io
from collections.abc import Iterator
from functools import cache
from gettext import GNUTranslations, NullTranslations
from numbers import Integral
from pathlib import Path
from typing import IO, Final
from uuid import uuid4

_FOLDER: Final = Path(__file__).parent
_OF_LANGUAGE: Final = "LC_MESSAGES"
_CONTEXT_ENDS: Final = "\x04"  # as GNU gettext writes a context before its key


class Translations(GNUTranslations):
    """The texts of a domain by their keys; the text of a key that it lacks is empty."""

    _catalog: dict[str | tuple[str, int], str]  # the one way to list what there is

    def __init__(self, compiled: IO[bytes]) -> None:
        super().__init__(compiled)
        self.add_fallback(_Missing())

    def text(self, key: str, n: object = None) -> str:
        """Return the text of a key; of one with plural forms, the form for a count."""
        counted = self.ngettext(key, key, int(n)) if isinstance(n, Integral) else ""
        return counted or self.gettext(key)

    def texts(self) -> dict[str, str]:
        """Return every text without a context by its key; of plural forms, the last."""
        return {key: text for context, key, text in self._listed() if not context}

    def by_context(self) -> dict[str, dict[str, str]]:
        """Return the texts of every key by their contexts; "" is that of the text without one."""
        found: dict[str, dict[str, str]] = {}
        for context, key, text in self._listed():
            found.setdefault(key, {})[context] = text
        return found

    def _listed(self) -> Iterator[tuple[str, str, str]]:
        for found, text in self._catalog.items():
            context, _, key = (found if isinstance(found, str) else found[0]).rpartition(_CONTEXT_ENDS)
            if key:  # "" has the header
                yield context, key, text


class _Missing(NullTranslations):
    """What gettext asks for a text that a domain lacks."""

    def gettext(self, message: str) -> str:
        return ""

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        return ""


def languages() -> tuple[str, ...]:
    """Return the codes of all languages (ISO 639-1)."""
    return tuple(sorted(path.parent.name for path in _FOLDER.glob(f"*/{_OF_LANGUAGE}")))


@cache
def translations(language: str, domain: str) -> Translations:
    """Return the translations of a domain into a language.

    Raises FileNotFoundError where the language has no such domain.
    """
    source = _FOLDER / language / _OF_LANGUAGE / f"{domain}.po"
    compiled = source.with_suffix(".mo")
    if _is_stale(compiled, source):
        return Translations(io.BytesIO(_compiled_now(source)))
    with compiled.open("rb") as file:
        return Translations(file)


def _is_stale(compiled: Path, source: Path) -> bool:
    """Whether a source is newer than what was made of it; an installed package has no source."""
    if not source.exists():
        return False
    return not compiled.exists() or compiled.stat().st_mtime_ns < source.stat().st_mtime_ns


def _compiled_now(source: Path) -> bytes:
    try:
        return compile_source(source)
    except OSError:
        return _compiled(source)  # a folder that cannot be written: the next process compiles it again


def compile_source(source: Path) -> bytes:
    """Leave beside a `.po` file the `.mo` file that is made of it, and return what that holds.

    It takes the place of the one before whole, as another process may be reading that. Raises OSError where
    the folder cannot be written.
    """
    made = _compiled(source)
    beside = source.with_suffix(f".mo.{uuid4().hex}")
    beside.write_bytes(made)
    beside.replace(source.with_suffix(".mo"))
    return made


def _compiled(source: Path) -> bytes:
    from babel.messages.mofile import write_mo  # only a checkout and a build have it
    from babel.messages.pofile import read_po

    made = io.BytesIO()
    with source.open("rb") as texts:
        write_mo(made, read_po(texts))
    return made.getvalue()
