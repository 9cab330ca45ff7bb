"""Links, commands and pictures of the pages exist."""

import re
from pathlib import Path

import pytest

_CHECKOUT = Path(__file__).parents[3]
_PAGES = [_CHECKOUT / "README.md", _CHECKOUT / "CHANGELOG.md", *sorted((_CHECKOUT / "docs").rglob("*.md"))]
_LARGEST_PICTURE_BYTES = 200_000
_MOST_WORDS = 1_200
_README = (_CHECKOUT / "README.md").read_text(encoding="utf-8")


def _named(path):
    return str(path.relative_to(_CHECKOUT))


@pytest.mark.parametrize("page", _PAGES, ids=_named)
def test_every_link_inside_the_repository_leads_somewhere(page):
    links = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))

    inside = [link.split("#")[0] for link in links if not re.match(r"[a-z]+:|#", link)]

    assert [link for link in inside if not (page.parent / link).exists()] == []


def test_pictures_are_small():
    pictures = list((_CHECKOUT / "docs" / "images").iterdir())

    assert pictures
    assert all(picture.stat().st_size < _LARGEST_PICTURE_BYTES for picture in pictures)


@pytest.mark.parametrize("target", re.findall(r"^make (\w+)", _README, flags=re.MULTILINE))
def test_every_make_target_of_the_readme_exists(target):
    makefile = (_CHECKOUT / "Makefile").read_text(encoding="utf-8")

    assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE)


def test_every_decision_is_listed_and_has_its_three_parts():
    folder = _CHECKOUT / "docs" / "decisions"
    records = sorted(path for path in folder.glob("0*.md"))
    listed = (folder / "README.md").read_text(encoding="utf-8")

    texts = {path.name: path.read_text(encoding="utf-8") for path in records}

    assert len({name[:4] for name in texts}) == len(texts)
    assert [name for name in texts if f"]({name})" not in listed] == []
    parts = ("## Context", "## Decision", "## Consequences", "## Rejected")
    assert [name for name, text in texts.items() if any(part not in text for part in parts)] == []


def test_the_page_on_campaigns_shows_the_one_in_the_folder():
    first_row = (_CHECKOUT / "docs/examples/campaign/calibration.csv").read_text(encoding="utf-8")

    page = (_CHECKOUT / "docs" / "engineer.md").read_text(encoding="utf-8")
    assert "\n".join(first_row.splitlines()[:2]) in page


def test_the_readme_is_read_in_five_minutes():
    assert len(_README.split()) <= _MOST_WORDS
