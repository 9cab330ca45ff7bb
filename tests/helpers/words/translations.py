"""Translations as their sources have them, read by the tools of gettext and not by the service."""

import re
from functools import cache
from pathlib import Path

from babel.messages.pofile import read_po

import truepose

FOLDER = Path(truepose.__file__).parent / "messages"
NAMES = "names"  # no keys, but names of documents, in the forms that a language has
TABLETS = ("tablet", "tracker_tablet")  # filled in by their pages
DOMAINS = tuple(sorted(path.stem for path in (FOLDER / "en" / "LC_MESSAGES").glob("*.po")))
SAID = tuple(domain for domain in DOMAINS if domain not in {NAMES, *TABLETS})


def source(language, domain):
    return FOLDER / language / "LC_MESSAGES" / f"{domain}.po"


@cache
def entries(language, domain):
    """Return what a domain has, in its order: (context, key, texts by plural form)."""
    with source(language, domain).open("rb") as file:
        read = read_po(file, abort_invalid=True)
    return tuple((one.context or "", *_of(one)) for one in read if one.id)


def _of(one):
    return (one.id[0], tuple(one.string)) if one.pluralizable else (one.id, (one.string,))


@cache
def texts(language, domains=SAID):
    """Return the texts of a language by their keys: all plural forms of each."""
    return {key: forms for domain in domains for _, key, forms in entries(language, domain)}


def every_text(language):
    """Yield the key and each text of what is said in a language."""
    for key, forms in texts(language).items():
        yield from ((key, text) for text in forms)


def without_blanks(text):
    return re.sub(r"\{[^}]*\}", "", text)
