"""The reference pages are those that the code writes."""

from tests.helpers.reference_pages import FOLDER, pages


def test_the_reference_says_what_the_code_says():
    kept = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md")}

    assert kept == pages(), "make reference writes them anew"
