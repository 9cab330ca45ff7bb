"""Pages as a browser finds them: for tests of what is written as HTML."""

import re
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser

_NOT_SHOWN = {"script", "style", "template"}


class Page(HTMLParser):
    """What a browser would find: elements with attributes, and the text between them."""

    def __init__(self, html):
        super().__init__()
        self.elements, self._texts = [], []
        self._hidden = False
        self._seen = []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self._hidden = tag in _NOT_SHOWN

    def handle_endtag(self, tag):
        self._hidden = False

    def handle_data(self, data):
        self._texts.append(data)
        if not self._hidden:
            self._seen.append(data)

    @property
    def pieces(self):
        """What is read on it, piece by piece: no program, no form of words or lines."""
        return [" ".join(data.split()) for data in self._seen if data.strip()]

    @property
    def text(self):
        return " ".join(" ".join(self._texts).split())

    @property
    def tags(self):
        return {tag for tag, _ in self.elements}


def leave_pictures_empty(patch):
    """Let reports put their pictures together and not paint them, which takes most of the time."""
    empty = '<svg height="1pt" width="1pt" viewBox="0 0 1 1"></svg>'
    patch.setattr("truepose.reports.figures.svg_rendering._write_svg", lambda _, file: file.write(empty))


_LOADED = {"src", "href", "xlink:href", "srcset", "data"}
HOSTILE = "<script>alert('x')</script><img src=http://evil.example/x onerror=alert(1)>\"&"


def assert_asks_nothing(html, *, pixels=False):
    """The page asks nothing from anywhere; `pixels`: a matrix may be a picture within it."""
    page = Page(html)
    assert not page.tags & {"script", "link", "iframe", "object", "embed", "base", "img"}
    loaded = [value for _, said in page.elements for name, value in said.items() if name in _LOADED]
    elsewhere = [value for value in loaded if not value.startswith("#")]
    assert all(pixels and value.startswith("data:image/png;base64,") for value in elsewhere), elsewhere
    there = {said["id"] for _, said in page.elements if "id" in said}
    assert {value[1:] for value in loaded if value.startswith("#")} <= there
    assert "@import" not in html


def assert_hostile_text_stays_text(page):
    """`HOSTILE` is read on the page, and is no element of it."""
    assert not page.tags & {"script", "img"}
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    assert HOSTILE in page.text


def assert_drawn_for_pages(svg):
    """The picture is well-formed, says what it is, and takes its colours from the page."""
    root = ElementTree.fromstring(svg)
    assert root.tag.endswith("svg")
    assert "width" not in root.attrib
    assert root.attrib["role"] == "img"
    assert root.attrib["aria-label"]
    assert "var(--ink)" in svg
    assert not re.search(r"#0[1-9a]0[1-9a]0[1-9a]", svg)  # no stand-in colour is left
    assert "style" not in svg  # which a page that allows none would not show


def links(reply):
    """Return where the links of a page lead, in their order."""
    return [attributes.get("href") for tag, attributes in Page(reply.text).elements if tag == "a"]
