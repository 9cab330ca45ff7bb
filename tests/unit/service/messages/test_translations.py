"""Translations say what their source says, whether they were compiled before or not."""

import os

import numpy as np
import pytest

from truepose.messages import translations as module

SOURCE = r"""
msgid ""
msgstr ""
"Content-Type: text/plain; charset=utf-8\n"
"Plural-Forms: nplurals=2; plural=(n > 1);\n"

msgid "greeting"
msgstr "Salut"

msgctxt "of"
msgid "arm {n}"
msgstr "du bras {n}"

msgid "arm {n}"
msgstr "bras {n}"

msgid "readings"
msgid_plural "readings"
msgstr[0] "{n} mesure"
msgstr[1] "{n} mesures"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A language of one domain, in a checkout."""
    folder = tmp_path / "fr" / "LC_MESSAGES"
    folder.mkdir(parents=True)
    (folder / "pages.po").write_text(SOURCE, encoding="utf-8")
    monkeypatch.setattr(module, "_FOLDER", tmp_path)
    return folder


def read():
    return module.translations.__wrapped__("fr", "pages")


def change(file, text, later_s):
    """Write a file, as of a time after that of its neighbour."""
    file.write_text(text, encoding="utf-8")
    made = file.with_suffix(".mo").stat().st_mtime
    os.utime(file, (made + later_s, made + later_s))


def test_a_text_is_found_by_its_key_and_one_that_is_not_there_is_empty(folder):
    assert read().text("greeting") == "Salut"
    assert read().text("parting") == ""
    assert read().text("parting", 2) == ""


@pytest.mark.parametrize(
    ("n", "text"), [(0, "{n} mesure"), (1, "{n} mesure"), (2, "{n} mesures"), (np.int64(24), "{n} mesures")]
)
def test_a_count_chooses_the_form_by_the_rule_of_the_language(folder, n, text):
    assert read().text("readings", n) == text


def test_a_count_of_a_text_without_plural_forms_is_a_value_like_others(folder):
    assert read().text("greeting", 2) == "Salut"


def test_texts_are_listed_by_key_and_by_context(folder):
    assert read().texts() == {"greeting": "Salut", "arm {n}": "bras {n}", "readings": "{n} mesures"}
    assert read().by_context()["arm {n}"] == {"": "bras {n}", "of": "du bras {n}"}


def test_what_was_compiled_is_read_again_as_long_as_its_source_is_not_newer(folder):
    read()
    change(folder / "pages.po", SOURCE.replace("Salut", "Bonjour"), later_s=-1)

    assert read().text("greeting") == "Salut"


def test_a_source_that_was_changed_is_compiled_anew(folder):
    read()
    change(folder / "pages.po", SOURCE.replace("Salut", "Bonjour"), later_s=1)

    assert read().text("greeting") == "Bonjour"
    assert sorted(path.name for path in folder.iterdir()) == ["pages.mo", "pages.po"]


def test_an_installed_package_has_no_source(folder):
    read()
    (folder / "pages.po").unlink()

    assert read().text("greeting") == "Salut"
    assert module.languages() == ("fr",)


def test_a_folder_that_cannot_be_written_is_read_all_the_same(folder, monkeypatch):
    def refuse(path, data):
        raise PermissionError(path)

    monkeypatch.setattr(module.Path, "write_bytes", refuse)

    assert read().text("greeting") == "Salut"
    assert [path.name for path in folder.iterdir()] == ["pages.po"]


def test_a_domain_that_is_not_there_is_refused(folder):
    with pytest.raises(FileNotFoundError):
        module.translations.__wrapped__("de", "pages")


def test_who_reads_while_a_build_compiles_anew_reads_one_whole_file(folder):
    module.compile_source(folder / "pages.po")
    with (folder / "pages.mo").open("rb") as compiled:
        (folder / "pages.po").write_text(SOURCE.replace("Salut", "Bonjour"), encoding="utf-8")
        module.compile_source(folder / "pages.po")

        assert module.Translations(compiled).text("greeting") == "Salut"
    assert read().text("greeting") == "Bonjour"
