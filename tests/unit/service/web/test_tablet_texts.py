"""The catalogue: every language has the same keys, the same blanks, each used, none missing."""

import re
from pathlib import Path

import pytest

import truepose.web.tablet
from truepose.messages.catalogue import LANGUAGES as SPOKEN
from truepose.messages.catalogue import TABLET, TRACKER_TABLET
from truepose.messages.translations import translations

HERE = Path(truepose.web.tablet.__file__).parent
LANGUAGES = {
    name: translations(name, TABLET).texts() | translations(name, TRACKER_TABLET).texts() for name in SPOKEN
}
CODE = "".join(path.read_text("utf-8") for path in (HERE / "static").rglob("*.js"))
PAGES = "".join(path.read_text("utf-8") for path in (HERE / "templates").glob("*.html"))
# Keys stand in the code as they are, never put together from parts: so each can be found.
USED = set(re.findall(r'"([a-z_]+\.[a-z_]+)"', CODE)) | set(
    re.findall(r'data-(?:text|label)="([^"]+)"', PAGES)
)
SAID_BY_THE_SERVICE = {"session.pause_asked"}  # of a session, whatever its language
KEPT_BY_THE_TABLET = {f"truepose.{name}" for name in ("language", "tablet", "person", "muted", "units")}


def blanks(text):
    return sorted(re.findall(r"\{(\w+)\}", text))


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_of_the_pages_has_the_same_keys(language):
    assert set(LANGUAGES[language]) == set(LANGUAGES["en"])


@pytest.mark.parametrize("key", LANGUAGES["en"])
def test_every_language_fills_in_the_same(key):
    said = [texts[key] for texts in LANGUAGES.values()]

    assert all(blanks(text) == blanks(LANGUAGES["en"][key]) for text in said)
    assert all(text.strip() for text in said)


def test_every_text_is_used_and_every_text_that_is_used_is_there():
    used = USED - KEPT_BY_THE_TABLET - SAID_BY_THE_SERVICE

    assert used == set(LANGUAGES["en"])


def test_no_word_for_people_stands_in_the_code():
    written = re.findall(r'(?:textContent = |write\([^,]+, |placeholder: |"aria-label": )"([^"]+)"', CODE)

    assert written == []


def test_french_keeps_its_spaces_before_high_punctuation():
    # A no-break space, so that no line begins with a colon.
    loose = [text for text in LANGUAGES["fr"].values() if re.search(r"[^\u00a0\d][:;!?»]", text)]

    assert loose == []
