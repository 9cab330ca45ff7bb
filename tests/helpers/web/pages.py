"""Pages as a browser finds them: for tests of what is written as HTML."""

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
