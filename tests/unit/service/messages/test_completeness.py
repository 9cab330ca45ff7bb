"""Every language says everything, fills in the same, and no key stands idle."""

import ast
import functools
import re
import string
from pathlib import Path

import pytest

import truepose
from tests.helpers.words.translations import (
    DOMAINS,
    NAMES,
    SAID,
    TABLETS,
    entries,
    every_text,
    source,
    texts,
)
from truepose.messages.catalogue import _DOMAINS, ENGLISH, LANGUAGES
from truepose.messages.translations import translations
from truepose.messages.units import KNOWN, Format

ROOT = Path(truepose.__file__).parent


def blanks(text):
    """Return the values of a text, with the digits of numbers; forms of names are a language's own."""
    parsed = string.Formatter().parse(text)
    values = [(name, spec or "") for _, name, spec, _ in parsed if name and name.isidentifier()]
    formed = [(name, Format.of(spec).form.lstrip(",")) for name, spec in values if name not in KNOWN]
    return {(name, form if re.fullmatch(r"(\.\d)?[efg]", form) else "") for name, form in formed}


@functools.cache
def sources():
    """Return the text of every module and template."""
    paths = (path for path in ROOT.rglob("*") if path.suffix in {".py", ".html"})
    return {path: path.read_text("utf-8") for path in paths}


@functools.cache
def said():
    """Return what is said by name: keys, each with the names of its values."""
    of_pages = [call for path, text in sources().items() if path.suffix == ".html" for call in _in_page(text)]
    of_code = [call for path, text in sources().items() if path.suffix == ".py" for call in _in_module(text)]
    return of_pages + of_code


def _in_page(text):
    for key, values in re.findall(r"\bsay\(\"([a-z_0-9.]+)\"([^}]*)\)", text):
        yield key, set(re.findall(r"(\w+)=", values))


def _in_module(text):
    if not re.search(r"\b(message|say)\(", text):
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and node.args and _called(node.func) in {"message", "say"}:
            values = {value.arg for value in node.keywords}
            yield from ((key.value, values) for key in _ends(node.args[0]) if isinstance(key, ast.Constant))


def _called(function):
    return getattr(function, "id", getattr(function, "attr", ""))


def _ends(expression):
    """Return what an expression may come to: both ends of a choice."""
    if isinstance(expression, ast.IfExp):
        return [*_ends(expression.body), *_ends(expression.orelse)]
    return [expression]


def test_a_catalogue_has_every_domain_that_is_no_page_s_own():
    assert set(LANGUAGES) >= {"en", "fr"}
    assert set(_DOMAINS) == set(SAID)


@pytest.mark.parametrize("domain", DOMAINS)
@pytest.mark.parametrize("language", LANGUAGES)
def test_the_service_reads_what_gettexts_tools_read(language, domain):
    read = translations(language, domain).by_context()

    assert read == {
        key: {c: forms[-1] for c, k, forms in entries(language, domain) if k == key} for key in read
    }
    assert set(read) == {key for _, key, _ in entries(language, domain)}


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_everything_and_nothing_else(language):
    for domain in (*SAID, *TABLETS):
        said = {key for _, key, _ in entries(language, domain)}
        assert said == {key for _, key, _ in entries(ENGLISH, domain)}, domain
    assert {key for _, key, _ in entries(ENGLISH, NAMES)} <= {key for _, key, _ in entries(language, NAMES)}
    assert [key for domain in DOMAINS for _, key, forms in entries(language, domain) if not all(forms)] == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_key_stands_twice_and_no_text_waits_for_its_translator(language):
    written = [source(language, domain).read_text("utf-8") for domain in DOMAINS]
    msgids = sum(len(re.findall(r"^msgid ", text, flags=re.MULTILINE)) for text in written)

    assert msgids == sum(len(entries(language, domain)) + 1 for domain in DOMAINS)
    assert len(texts(language)) == sum(len(entries(language, domain)) for domain in SAID)
    assert re.findall(r"^#[,~].*", "\n".join(written), flags=re.MULTILINE) == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_fills_in_the_same_numbers_alike(language):
    own, documents = texts(language), texts(ENGLISH)

    assert [key for key in documents if _filled(own[key]) != _filled(documents[key])] == []


def _filled(forms):
    """Return what any form of a text fills in: "one cause" needs no number."""
    return set().union(*map(blanks, forms))


def test_every_key_that_is_said_is_there():
    assert sorted({key for key, _ in said()} - set(texts(ENGLISH))) == []


def test_every_text_with_plural_forms_is_given_its_count():
    counted = {key for key, forms in texts("fr").items() if len(forms) > 1}

    assert {"work.total", "status.outliers"} <= {key for key, _ in said()} & counted
    assert [key for key, values in said() if key in counted and not values & {"n", None}] == []


@pytest.mark.parametrize(
    ("language", "forms"),
    [
        ("de", [1, 0, 1]),
        ("en", [1, 0, 1]),
        ("es", [1, 0, 1]),
        ("fr", [0, 0, 1]),
        ("ja", [0] * 3),
        ("zh", [0] * 3),
    ],
)
def test_every_file_chooses_plural_forms_by_the_rule_of_its_language(language, forms):
    for domain in DOMAINS:
        assert [translations(language, domain).plural(n) for n in (0, 1, 2)] == forms, domain


def test_every_key_is_said_somewhere():
    written = {key for text in sources().values() for key in re.findall(r"[\"']([\w.]+)[\"']", text)}
    apart = ("list.", "error.TP-", "page.errors.group.")  # `test_error_codes`
    idle = {key for key in texts(ENGLISH) if key not in written and not key.startswith(apart)}

    assert idle == set()


def test_french_keeps_its_spaces_before_high_punctuation():
    loose = [key for key, text in every_text("fr") if re.search(r"[^\u00a0\w}][:;!?%»](?![\w./])", text)]

    assert loose == []
